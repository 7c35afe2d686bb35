// The least and the greatest value that a field can take in each block, from the samples that have influence there.

import generated::block::params as around;
import generated::layer::layer;
import generated::pass::ranges_out;
import generated::sizes::BLOCK_VOXELS;
import package::empty::is_empty;
import package::ray::INFINITE;
import slot::field::{locate, field_value};
import slot::values::scalar_of;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) block: vec3u) {
  if (any(block >= around.blocks)) { return; }
  let low = max(block * BLOCK_VOXELS, vec3u(around.reach)) - around.reach;
  let high = min((block + 1u) * BLOCK_VOXELS + around.reach, vec3u(layer.size) - 1u);
  var found = vec2f(INFINITE, -INFINITE);
  for (var z = low.z; z <= high.z; z++) {
    for (var y = low.y; y <= high.y; y++) {
      for (var x = low.x; x <= high.x; x++) {
        let value = scalar_of(field_value(locate(vec3f(vec3u(x, y, z)))));
        let known = !is_empty(value);
        found = vec2f(select(found.x, min(found.x, value), known), select(found.y, max(found.y, value), known));
      }
    }
  }
  let beyond = select(0.0, around.overshoot * (found.y - found.x), found.y >= found.x);
  ranges_out[(block.z * around.blocks.y + block.y) * around.blocks.x + block.x] = found + vec2f(-beyond, beyond);
}
