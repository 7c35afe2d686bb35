// Voxels of a grid whose samples lie in layers of 2-D textures.

import generated::field::grid;
import generated::layer::layer;
import package::field::layers::turned;

fn texel_at(voxel: vec3i) -> vec4f { return stacked_at(voxel, 0.0); }

// The same of a group of channels, so many behind the first.
fn stacked_at(voxel: vec3i, group: f32) -> vec4f {
  let at = vec3i(turned(vec3f(voxel)));
  return textureLoad(grid, at.xy, at.z + i32(group * turned(layer.size).z), 0);
}
