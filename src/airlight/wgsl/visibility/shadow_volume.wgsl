// The share of each light that comes through to cells; ambient light reaches every point.

import generated::layer::layer;
import generated::lights::lights;
import generated::shadow_volume::{params, shadows, shadows_sampler};
import package::lights::DIRECTIONAL;

fn visibility(light_index: u32, p_world: vec3f) -> vec3f {
  // Look towards the light, so that a surface is not in the shadow of the cell that it lies in.
  let source = lights[light_index];
  let is_near = source.kind != DIRECTIONAL;
  let way = select(source.vector, source.vector - p_world, is_near);
  let distance = max(length(way), 1e-20);
  let share = select(params.bias_world, min(params.bias_world, distance), is_near) / distance;
  let p_cell = ((layer.index_from_world * vec4f(p_world + share * way, 1.0)).xyz + 0.5) * params.cells_per_voxel + 1.0;
  // Lights that cast shadows lie one behind the other, and do not run into each other.
  let bit = 1u << light_index;
  let before = f32(countOneBits(params.casting & (bit - 1u)));
  let z = clamp(p_cell.z, 0.5, params.cells_z - 0.5) + before * params.cells_z;
  let found = textureSampleLevel(shadows, shadows_sampler, vec3f(p_cell.xy, z) * params.unit_per_cell, 0.0).rgb;
  return select(vec3f(1.0), found, (params.casting & bit) != 0u);
}

fn ambient_visibility(p_world: vec3f) -> f32 { return 1.0; }
