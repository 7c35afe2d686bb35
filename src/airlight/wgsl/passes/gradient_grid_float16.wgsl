// Gradients at all voxels, once, into a texture of half floats.

import generated::layer::layer;
import generated::pass::gradients_float16_out;
import generated::slice::params as slice;
import package::gradient::texel::gradient_texel;
import slot::field::locate;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let voxel = vec3u(id.xy, id.z + slice.first_z);
  if (any(vec3f(voxel) >= layer.size)) { return; }
  textureStore(gradients_float16_out, voxel, gradient_texel(locate(vec3f(voxel))));
}
