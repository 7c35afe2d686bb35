// The value of the nearest voxel; empty samples stay empty.

import generated::layer::layer;
import generated::sizes::Values;
import package::ray::INFINITE;
import slot::taps::{PARTS, keep_sum, scalar_in, tap};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let voxel = vec3i(clamp(floor(place.p_index + 0.5), vec3f(0.0), layer.size - 1.0));
  var values: Values;
  for (var part = 0u; part < PARTS; part++) { keep_sum(tap(voxel, part), part, &values); }
  return values;
}

fn field_scalar(place: Place) -> f32 { return scalar_in(field_value(place)); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
