// Colour and extinction of the transfer function at all voxels, once, into a table.

import generated::classify::params as classify;
import generated::layer::layer;
import generated::pass::classified_out;
import generated::slice::params as slice;
import package::empty::EMPTY;
import package::sample::Sample;
import slot::field::{locate, field_value};
import slot::transfer::medium;
import slot::values::is_gap;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let voxel = vec3u(id.xy, id.z + slice.first_z);
  if (any(vec3f(voxel) >= layer.size)) { return; }
  let p_index = vec3f(voxel);
  let here = Sample(field_value(locate(p_index)), vec3f(0.0), p_index, vec3f(0.0), 0.0);
  let found = medium(here);
  let kept = vec4f(found.rgb * select(1.0, found.extinction, classify.weighs != 0u), found.extinction);
  textureStore(classified_out, voxel, select(kept, vec4f(EMPTY), is_gap(here.value)));
}
