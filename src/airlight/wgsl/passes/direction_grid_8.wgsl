// Numbers of directions at all voxels, once, in 8 bits.

import generated::layer::layer;
import generated::pass::numbers8_out;
import generated::slice::params as slice;
import package::lighting::number::four_numbers;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let texel = vec3u(id.xy, id.z + slice.first_z);
  if (any(vec3f(vec3u(4u * texel.x, texel.yz)) >= layer.size)) { return; }
  textureStore(numbers8_out, texel, four_numbers(texel));
}
