// Voxels of a grid whose samples lie in layers of 2-D textures, and what lies between them: across a layer by the texture unit,
// between two layers in the shader.

import generated::field::{BETWEEN, grid, grid_sampler};
import generated::layer::layer;
import package::field::layers::turned;
import slot::lookup::layer_at;

fn texel_at(voxel: vec3i) -> vec4f { return stacked_at(voxel, 0.0); }

fn stacked_at(voxel: vec3i, group: f32) -> vec4f {
  let at = vec3i(turned(vec3f(voxel)));
  return textureLoad(grid, at.xy, at.z + i32(group * turned(layer.size).z), 0);
}

fn sample_at(p_index: vec3f) -> vec4f { return stacked_sample_at(p_index, 0.0); }

fn stacked_sample_at(p_index: vec3f, group: f32) -> vec4f {
  let here = around_layers(p_index);
  let first = u32(group * turned(layer.size).z);
  var texel = textureSampleLevel(grid, grid_sampler, here.p_unit, first + here.low, 0.0);
  if (BETWEEN) { texel = mix(texel, textureSampleLevel(grid, grid_sampler, here.p_unit, first + here.high, 0.0), here.share); }
  return texel;
}

fn level_at(p_unit: vec3f, level: f32) -> vec4f {
  let coarsest = f32(textureNumLevels(grid) - 1u);
  let within = clamp(level, 0.0, coarsest);
  let fine = floor(within);
  return mix(on_level(p_unit, fine), on_level(p_unit, min(fine + 1.0, coarsest)), within - fine);
}

// A level has fewer layers: they are the first of as many as the finest has.
fn on_level(p_unit: vec3f, level: f32) -> vec4f {
  let p = turned(p_unit);
  let count = max(floor(turned(layer.size).z / f32(1u << u32(level))), 1.0);
  let along = clamp(p.z * count - 0.5, 0.0, count - 1.0);
  let low = floor(along);
  let first = textureSampleLevel(grid, grid_sampler, p.xy, u32(low), level);
  return mix(first, textureSampleLevel(grid, grid_sampler, p.xy, u32(min(low + 1.0, count - 1.0)), level), along - low);
}

fn made_texel_at(made: texture_2d_array<f32>, voxel: vec3i) -> vec4f {
  let at = vec3i(turned(vec3f(voxel)));
  return textureLoad(made, at.xy, at.z, 0);
}

fn made_at(made: texture_2d_array<f32>, made_sampler: sampler, p_index: vec3f) -> vec4f {
  let here = around_layers(p_index);
  var texel = layer_at(made, made_sampler, here.p_unit, here.low);
  if (BETWEEN) { texel = mix(texel, layer_at(made, made_sampler, here.p_unit, here.high), here.share); }
  return texel;
}

// The two layers round a place, the share of the second one, and the place in them; without it the nearest one.
struct AroundLayers { p_unit: vec2f, low: u32, high: u32, share: f32 }

fn around_layers(p_index: vec3f) -> AroundLayers {
  let p = turned(p_index);
  let last = turned(layer.size).z - 1.0;
  let along = clamp(p.z, 0.0, last);
  let low = floor(select(along + 0.5, along, BETWEEN));
  return AroundLayers((p.xy + 0.5) * turned(layer.inverse_size).xy, u32(low), u32(min(low + 1.0, last)), along - low);
}
