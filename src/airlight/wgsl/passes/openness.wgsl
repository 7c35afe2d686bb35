// Transmittance from each cell through all layers, averaged over directions all round.

import generated::occlusion::params as occlusion;
import generated::pass::openness_out;
import generated::slice::params as slice;
import next::hides::depth_round;

const GOLDEN_ANGLE: f32 = 2.3999632;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let cell = vec3u(id.xy, id.z + slice.first_z);
  if (any(cell >= occlusion.cells)) { return; }
  let middle = vec3f(cell) + 0.5;
  var sum = 0.0;
  for (var i = 0u; i < occlusion.directions; i++) {
    sum += exp(-depth_round(middle, occlusion.cells_from_world * direction(i), occlusion.cell_world));
  }
  textureStore(openness_out, cell, vec4f(sum / f32(occlusion.directions), 0.0, 0.0, 0.0));
}

// Directions on a spiral from pole to pole: each stands for as much of the sphere.
fn direction(i: u32) -> vec3f {
  let z = 1.0 - (2.0 * f32(i) + 1.0) / f32(occlusion.directions);
  let turn = GOLDEN_ANGLE * f32(i);
  return vec3f(sqrt(1.0 - z * z) * vec2f(cos(turn), sin(turn)), z);
}
