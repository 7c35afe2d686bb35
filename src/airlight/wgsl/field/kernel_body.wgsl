// A filter whose kernel is a table over a cube: the weight and its derivatives along x, y and z; beyond the faces of the grid
// voxels go on as the outer ones.

import generated::field::{grid, params, weights, weights_sampler};
import generated::layer::layer;
import generated::sizes::Values;
import package::field::around::around;
import package::ray::INFINITE;
import slot::lookup::table_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let found = sums(place.p_index);
  return found.value.x / found.weight.x * layer.value_scale + layer.value_offset;
}

fn field_derivative(place: Place) -> vec3f {
  let found = sums(place.p_index);
  return (found.value.yzw - found.weight.yzw * (found.value.x / found.weight.x)) / found.weight.x * layer.value_scale;
}

// Sums of weights and their derivatives, with and without the voxels' texels.
struct Sums { value: vec4f, weight: vec4f }

fn sums(p_index: vec3f) -> Sums {
  let radius = f32(params.taps / 2u);
  let here = around(p_index, i32(params.taps / 2u));
  var found: Sums;
  for (var tap = 0u; tap < params.taps * params.taps * params.taps; tap++) {
    let place = vec3u(tap, tap / params.taps, tap / (params.taps * params.taps)) % params.taps;
    let distance = here.share + (radius - 1.0) - vec3f(place);
    let place_unit = ((distance / radius + 1.0) * 0.5 * f32(params.places - 1u) + 0.5) / f32(params.places);
    let weight = table_at(weights, weights_sampler, place_unit);
    found.weight += weight;
    found.value += weight * textureLoad(grid, clamp(here.first + vec3i(place), vec3i(0), here.last), 0).r;
  }
  return found;
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
