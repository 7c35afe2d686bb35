// Trilinear interpolation by the texture unit, four channels at a time.

import generated::field::params;
import generated::layer::layer;
import generated::sizes::{Values, GROUPS};
import package::field::cell::cell_derivative;
import package::field::channels::weighted_sum;
import package::ray::INFINITE;
import slot::voxels::stacked_sample_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  var values: Values;
  for (var group = 0u; group < GROUPS; group++) {
    let texel = stacked_sample_at(place.p_index, params.stacked[group]);
    values[group] = texel * layer.channel_scale[group] + layer.channel_offset[group];
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return weighted_sum(field_value(place)); }

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
