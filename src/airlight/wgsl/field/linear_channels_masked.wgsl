// Trilinear interpolation of the samples that are there, channel by channel, their weights normalised; empty where they have
// less than half.

import generated::field::grid;
import generated::layer::layer;
import generated::sizes::{Values, GROUPS};
import package::empty::EMPTY;
import package::field::channels::{first_slice, weighted_sum};
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let p = clamp(place.p_index, vec3f(0.0), layer.size - 1.0);
  let low = floor(p);
  let w = p - low;
  var values: Values;
  for (var group = 0u; group < GROUPS; group++) {
    let first = vec3f(0.0, 0.0, first_slice(group));
    var sum = vec4f(0.0);
    var weight = vec4f(0.0);
    for (var corner = 0u; corner < 8u; corner++) {
      let high = vec3f(vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u));
      let share = mix(1.0 - w, w, high);
      let texel = textureLoad(grid, vec3i(min(low + high, layer.size - 1.0) + first), 0);
      let there = select(vec4f(share.x * share.y * share.z), vec4f(0.0), texel <= vec4f(EMPTY));
      sum += select(texel, vec4f(0.0), texel <= vec4f(EMPTY)) * there;
      weight += there;
    }
    values[group] = select(sum / max(weight, vec4f(1e-30)), vec4f(EMPTY), weight < vec4f(0.5));
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return weighted_sum(field_value(place)); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
