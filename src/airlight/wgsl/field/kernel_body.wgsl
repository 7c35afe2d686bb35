// A filter whose kernel is a table over a cube: the weight and its derivatives along x, y and z; beyond the faces of the grid
// voxels go on as the outer ones. Weights are divided by their sum at each place.

import generated::field::{params, weights, weights_sampler};
import generated::sizes::Values;
import package::field::around::{Around, around, tap_at};
import package::ray::INFINITE;
import slot::lookup::table_at;
import slot::taps::{PARTS, Tap, keep_sum, scalar_in, slope_of_sum};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let here = around(place.p_index, i32(params.taps / 2u));
  let count = tap_count();
  var values: Values;
  for (var part = 0u; part < PARTS; part++) {
    var sum = Tap();
    var total = 0.0;
    for (var number = 0u; number < count; number++) {
      let weight = weight_of(here, number).x;
      sum += tap_at(here, steps_to(number), part) * weight;
      total += weight;
    }
    keep_sum(sum * (1.0 / total), part, &values);
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return scalar_in(field_value(place)); }

fn field_derivative(place: Place) -> vec3f {
  let here = around(place.p_index, i32(params.taps / 2u));
  let count = tap_count();
  var found = vec3f(0.0);
  for (var part = 0u; part < PARTS; part++) {
    var sum = Tap();
    var along_x = Tap();
    var along_y = Tap();
    var along_z = Tap();
    var total = vec4f(0.0);
    for (var number = 0u; number < count; number++) {
      let weight = weight_of(here, number);
      let voxel = tap_at(here, steps_to(number), part);
      sum += voxel * weight.x;
      along_x += voxel * weight.y;
      along_y += voxel * weight.z;
      along_z += voxel * weight.w;
      total += weight;
    }
    // The rule for quotients, twice: here for the weights of all voxels, in `slope_of_sum` for those of the ones that are there.
    let mean = sum * (1.0 / total.x);
    found += vec3f(
      slope_of_sum(mean, (along_x - mean * total.y) * (1.0 / total.x), part),
      slope_of_sum(mean, (along_y - mean * total.z) * (1.0 / total.x), part),
      slope_of_sum(mean, (along_z - mean * total.w) * (1.0 / total.x), part),
    );
  }
  return found;
}

// The table, which has no such depth, is asked as well: Mesa 22.3 (lavapipe) compiles a loop that ends by a uniform anew for each
// dispatch.
fn tap_count() -> u32 { return max(params.taps * params.taps * params.taps, textureDimensions(weights).z >> 16u); }

fn steps_to(number: u32) -> vec3i {
  return vec3i(vec3u(number, number / params.taps, number / (params.taps * params.taps)) % params.taps);
}

// The weight of a voxel and its derivatives.
fn weight_of(here: Around, number: u32) -> vec4f {
  let radius = f32(params.taps / 2u);
  let distance = here.share + (radius - 1.0) - vec3f(steps_to(number));
  let place_unit = ((distance / radius + 1.0) * 0.5 * f32(params.places - 1u) + 0.5) / f32(params.places);
  return table_at(weights, weights_sampler, place_unit);
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
