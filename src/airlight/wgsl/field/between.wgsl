// Places between layers of 2-D textures.

import generated::field::{BETWEEN, grid, grid_sampler};
import generated::layer::layer;
import package::field::layers::turned;

// The two layers round a place, the share of the second one, and the place in them; without it the nearest one.
struct Between { p_unit: vec2f, low: u32, high: u32, share: f32 }

fn between_layers(p_index: vec3f) -> Between {
  let p = turned(p_index);
  let last = turned(layer.size).z - 1.0;
  let along = clamp(p.z, 0.0, last);
  let low = floor(select(along + 0.5, along, BETWEEN));
  return Between((p.xy + 0.5) * turned(layer.inverse_size).xy, u32(low), u32(min(low + 1.0, last)), along - low);
}

// The samples there [data].
fn stacked_value(p_index: vec3f) -> f32 {
  let here = between_layers(p_index);
  var texel = fetched(here.p_unit, here.low);
  if (BETWEEN) { texel = mix(texel, fetched(here.p_unit, here.high), here.share); }
  return texel * layer.value_scale + layer.value_offset;
}

fn fetched(p_unit: vec2f, number: u32) -> f32 { return textureSampleLevel(grid, grid_sampler, p_unit, number, 0.0).r; }
