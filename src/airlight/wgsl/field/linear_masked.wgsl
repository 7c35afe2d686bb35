// Trilinear interpolation of the voxels that are there, their weights normalised; empty where they have less than half.

import generated::linear_masked::grid;
import generated::layer::layer;
import package::empty::{EMPTY, is_empty};
import package::ray::INFINITE;
import generated::sizes::Values;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let p = clamp(place.p_index, vec3f(0.0), layer.size - 1.0);
  let low = floor(p);
  let w = p - low;
  var sum = vec2f(0.0);
  for (var corner = 0u; corner < 8u; corner++) {
    let high = vec3f(vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u));
    let share = mix(1.0 - w, w, high);
    let value = textureLoad(grid, vec3i(min(low + high, layer.size - 1.0)), 0).r;
    let weight = select(share.x * share.y * share.z, 0.0, is_empty(value));
    sum += vec2f(select(value, 0.0, is_empty(value)), 1.0) * weight;
  }
  return select(sum.x / max(sum.y, 1e-30), EMPTY, sum.y < 0.5);
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
