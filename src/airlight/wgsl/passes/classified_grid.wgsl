// Colour and extinction of the transfer function at all voxels, once, into a table.

import generated::layer::layer;
import generated::pass::classified_out;
import generated::slice::params as slice;
import package::transfer::voxel_medium::voxel_medium;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let voxel = vec3u(id.xy, id.z + slice.first_z);
  if (any(vec3f(voxel) >= layer.size)) { return; }
  textureStore(classified_out, voxel, voxel_medium(vec3f(voxel)));
}
