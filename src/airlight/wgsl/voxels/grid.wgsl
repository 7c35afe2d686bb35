// Voxels of a grid whose samples lie in a 3-D texture.

import generated::field::grid;
import generated::layer::layer;

fn texel_at(voxel: vec3i) -> vec4f { return textureLoad(grid, voxel, 0); }

// The same of a group of channels, so many behind the first.
fn stacked_at(voxel: vec3i, group: f32) -> vec4f {
  return textureLoad(grid, vec3i(voxel.xy, voxel.z + i32(group * layer.size.z)), 0);
}
