// Transmittance from each cell, averaged over directions all round.

import generated::occlusion::params as occlusion;
import generated::pass::{occluders, occluders_sampler, openness_out};
import generated::slice::params as slice;

const GOLDEN_ANGLE: f32 = 2.3999632;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let cell = vec3u(id.xy, id.z + slice.first_z);
  if (any(cell >= occlusion.cells)) { return; }
  let middle = vec3f(cell) + 0.5;
  var sum = 0.0;
  for (var i = 0u; i < occlusion.directions; i++) {
    let way = occlusion.cells_from_world * direction(i);
    var depth = 0.0;
    for (var k = 0u; k < occlusion.steps; k++) {
      depth += depth_at(middle + (occlusion.cell_world + (f32(k) + 0.5) * occlusion.step_world) * way);
    }
    sum += exp(-depth * occlusion.step_world / occlusion.cell_world);
  }
  textureStore(openness_out, cell, vec4f(sum / f32(occlusion.directions), 0.0, 0.0, 0.0));
}

// Directions on a spiral from pole to pole: each stands for as much of the sphere.
fn direction(i: u32) -> vec3f {
  let z = 1.0 - (2.0 * f32(i) + 1.0) / f32(occlusion.directions);
  let turn = GOLDEN_ANGLE * f32(i);
  return vec3f(sqrt(1.0 - z * z) * vec2f(cos(turn), sin(turn)), z);
}

// Optical depth of a cell's length here; beyond the volume there is nothing.
fn depth_at(p_cell: vec3f) -> f32 {
  let inside = all(p_cell >= vec3f(0.0)) && all(p_cell <= occlusion.last);
  return select(0.0, textureSampleLevel(occluders, occluders_sampler, p_cell / vec3f(occlusion.cells), 0.0).r, inside);
}
