// What has come to each cell through its own layer, dimmed by the other layers along its ray to a light.

import generated::occlusion::params as occlusion;
import generated::pass::{shadows_before, shadows_out};
import generated::shadow::params as shadow;
import package::shadow_along::through_along_ray;
import package::shadow_cells::middle_of;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let texel = vec3u(id.xy, id.z + shadow.slice);
  if (any(texel >= occlusion.cells + 2u)) { return; }
  let at = texel + vec3u(0u, 0u, shadow.stack_z);
  let came = textureLoad(shadows_before, at, 0).rgb;
  textureStore(shadows_out, at, vec4f(came * through_along_ray(middle_of(texel)), 1.0));
}
