// Trilinear interpolation by the texture unit, four channels at a time.

import generated::field::{grid, grid_sampler, params};
import generated::layer::layer;
import generated::sizes::{Values, GROUPS};
import package::field::cell::cell_derivative;
import package::field::channels::{first_slice, weighted_sum};
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  // Beyond the outer centres of a group lie those of another.
  let p = vec3f(place.p_index.xy, clamp(place.p_index.z, 0.0, layer.size.z - 1.0)) + 0.5;
  var values: Values;
  for (var group = 0u; group < GROUPS; group++) {
    let z = (p.z + first_slice(group)) * params.slice;
    let texel = textureSampleLevel(grid, grid_sampler, vec3f(p.xy * layer.inverse_size.xy, z), 0.0);
    values[group] = texel * layer.channel_scale[group] + layer.channel_offset[group];
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return weighted_sum(field_value(place)); }

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
