// Ambient light by the openness of cells; lights reach every point.

import generated::ambient_occlusion::{params, openness, openness_sampler};
import generated::layer::layer;

fn visibility(light_index: u32, p_world: vec3f) -> vec3f { return vec3f(1.0); }

fn ambient_visibility(p_world: vec3f) -> f32 {
  let p_index = (layer.index_from_world * vec4f(p_world, 1.0)).xyz;
  return textureSampleLevel(openness, openness_sampler, (p_index + 0.5) * params.unit_per_voxel, 0.0).r;
}
