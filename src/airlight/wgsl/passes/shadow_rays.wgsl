// What comes through to each cell along its own ray to a light.

import generated::occlusion::params as occlusion;
import generated::pass::shadows_out;
import generated::shadow::params as shadow;
import package::shadow_cells::{middle_of, to_light, stretch, through};

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let texel = vec3u(id.xy, id.z + shadow.slice);
  if (any(texel >= occlusion.cells + 2u)) { return; }
  let middle = middle_of(texel);
  let way = to_light(middle);
  let met = stretch(middle, way);
  let end = select(met.y, min(met.y, 1.0), shadow.light.w > 0.0);
  let here = select(vec3f(1.0), through(middle, way, met.x, max(end, met.x)), met.x < end);
  textureStore(shadows_out, texel + vec3u(0u, 0u, shadow.stack_z), vec4f(here, 1.0));
}
