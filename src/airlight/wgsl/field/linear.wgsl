// Trilinear interpolation by the texture unit.

import generated::linear::{grid, grid_sampler};
import generated::layer::layer;
import package::field::cell::cell_derivative;
import package::ray::INFINITE;
import generated::sizes::Values;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let p_unit = (place.p_index + 0.5) * layer.inverse_size;
  return textureSampleLevel(grid, grid_sampler, p_unit, 0.0).r * layer.value_scale + layer.value_offset;
}

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
