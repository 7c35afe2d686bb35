// What lies round pixels, as a texture: cells spread over their neighbours.
//
// A bilateral filter (Durand and Dorsey 2002) on a grid of cells and steps of luminance (Paris and Durand 2006): what is far
// in luminance is as far as what is far in space, and where nothing is left in between there is no halo. A cell's width, the
// spreading here and the interpolation of who reads have together the variance of the filter.

import generated::pass::{surround_out, surround_sums};
import generated::sizes::{SURROUND_STEPS, WORKGROUP_X, WORKGROUP_Y};
import generated::surround::params;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= params.cells) || id.z >= SURROUND_STEPS) { return; }
  let last = vec2i(params.cells) - 1;
  var sum = vec2f(0.0);
  for (var y = -1; y <= 1; y++) {
    for (var x = -1; x <= 1; x++) {
      let cell = vec2i(id.xy) + vec2i(x, y);
      let there = clamp(cell, vec2i(0), last);
      let weight = select(0.0, f32((2 - abs(x)) * (2 - abs(y))), all(cell == there));
      sum += weight * surround_sums[(id.z * params.cells.y + u32(there.y)) * params.cells.x + u32(there.x)];
    }
  }
  textureStore(surround_out, id, vec4f(sum / f32(16u * params.cell_px * params.cell_px), 0.0, 0.0));
}
