// Voxels of a grid whose samples lie in a 3-D texture, and what lies between them. Fields that read the grid in these names may be
// read from layers of 2-D textures, too: `stack.wgsl`.

import generated::field::{grid, grid_sampler};
import generated::layer::layer;
import slot::lookup::table_at;

fn texel_at(voxel: vec3i) -> vec4f { return textureLoad(grid, voxel, 0); }

// The same of a group of channels, so many behind the first.
fn stacked_at(voxel: vec3i, group: f32) -> vec4f {
  return textureLoad(grid, vec3i(voxel.xy, voxel.z + i32(group * layer.size.z)), 0);
}

// Trilinear interpolation by the texture unit at any place; beyond the outer centres what is there.
fn sample_at(p_index: vec3f) -> vec4f { return textureSampleLevel(grid, grid_sampler, (p_index + 0.5) * layer.inverse_size, 0.0); }

// The same of a group of channels: beyond the outer centres of a group lie those of another.
fn stacked_sample_at(p_index: vec3f, group: f32) -> vec4f {
  let z = clamp(p_index.z, 0.0, layer.size.z - 1.0) + group * layer.size.z;
  let deep = f32(textureDimensions(grid).z);
  return textureSampleLevel(grid, grid_sampler, (vec3f(p_index.xy, z) + 0.5) * vec3f(layer.inverse_size.xy, 1.0 / deep), 0.0);
}

// The same of one channel on a level of detail, and straight between two of them; the grid goes from 0 to 1.
fn level_at(p_unit: vec3f, level: f32) -> vec4f { return textureSampleLevel(grid, grid_sampler, p_unit, level); }

// A table that was made of the voxels, at one of them, and interpolated at any place.
fn made_texel_at(made: texture_3d<f32>, voxel: vec3i) -> vec4f { return textureLoad(made, voxel, 0); }

fn made_at(made: texture_3d<f32>, made_sampler: sampler, p_index: vec3f) -> vec4f {
  return table_at(made, made_sampler, (p_index + 0.5) * layer.inverse_size);
}
