// Colour and extinction of the transfer function at all voxels, once, into layers of 2-D textures.

import generated::layer::layer;
import generated::pass::classified_stack_out;
import generated::slice::params as slice;
import package::field::layers::turned;
import package::transfer::voxel_medium::voxel_medium;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let voxel = vec3u(id.xy, id.z + slice.first_z);
  if (any(vec3f(voxel) >= layer.size)) { return; }
  let at = vec3u(turned(vec3f(voxel)));
  textureStore(classified_stack_out, at.xy, at.z, voxel_medium(vec3f(voxel)));
}
