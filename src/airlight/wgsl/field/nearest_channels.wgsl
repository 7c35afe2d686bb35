// The values of the nearest voxel; empty samples stay empty.

import generated::field::grid;
import generated::layer::layer;
import generated::sizes::{Values, GROUPS};
import package::field::channels::{first_slice, weighted_sum};
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let voxel = clamp(floor(place.p_index + 0.5), vec3f(0.0), layer.size - 1.0);
  var values: Values;
  for (var group = 0u; group < GROUPS; group++) {
    let texel = textureLoad(grid, vec3i(vec3f(voxel.xy, voxel.z + first_slice(group))), 0);
    values[group] = texel * layer.channel_scale[group] + layer.channel_offset[group];
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return weighted_sum(field_value(place)); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
