// Gradients at all voxels, once, into a texture; scaled so that half floats hold them well.

import generated::layer::layer;
import generated::pass::gradients_out;
import generated::slice::params as slice;
import slot::field::locate;
import slot::gradient::field_gradient;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let voxel = vec3u(id.xy, id.z + slice.first_z);
  if (any(vec3f(voxel) >= layer.size)) { return; }
  let gradient = field_gradient(locate(vec3f(voxel))) / layer.gradient_scale;
  textureStore(gradients_out, voxel, vec4f(gradient, 0.0));
}
