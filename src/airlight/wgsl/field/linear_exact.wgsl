// Trilinear interpolation with weights in full precision.

import generated::sizes::Values;
import package::field::cell::{corners_at, cell_derivative, cell_sum};
import package::ray::INFINITE;
import slot::taps::{PARTS, keep_sum, scalar_in};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let corners = corners_at(place.p_index);
  var values: Values;
  for (var part = 0u; part < PARTS; part++) { keep_sum(cell_sum(corners, part), part, &values); }
  return values;
}

fn field_scalar(place: Place) -> f32 { return scalar_in(field_value(place)); }

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
