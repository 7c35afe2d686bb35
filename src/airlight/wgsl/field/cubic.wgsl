// Cubic filters over four voxels an axis, whose weights are polynomials of the place within a cell; beyond the faces of the grid
// voxels go on as the outer ones.

import generated::field::params;
import generated::sizes::Values;
import package::field::around::{Around, around, tap_at};
import package::ray::INFINITE;
import slot::taps::{PARTS, Tap, keep_sum, scalar_in, slope_of_sum};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let here = around(place.p_index, 2);
  let x = params.basis * powers(here.share.x);
  let y = params.basis * powers(here.share.y);
  let z = params.basis * powers(here.share.z);
  var values: Values;
  for (var part = 0u; part < PARTS; part++) {
    var sum = Tap();
    for (var k = 0; k < 4; k++) {
      let plane = row_sum(here, 0, k, part, x) * y.x + row_sum(here, 1, k, part, x) * y.y
        + row_sum(here, 2, k, part, x) * y.z + row_sum(here, 3, k, part, x) * y.w;
      sum += plane * z[k];
    }
    keep_sum(sum, part, &values);
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return scalar_in(field_value(place)); }

fn field_derivative(place: Place) -> vec3f {
  let here = around(place.p_index, 2);
  let x = params.basis * powers(here.share.x);
  let y = params.basis * powers(here.share.y);
  let z = params.basis * powers(here.share.z);
  let dx = params.basis * slopes(here.share.x);
  let dy = params.basis * slopes(here.share.y);
  let dz = params.basis * slopes(here.share.z);
  var found = vec3f(0.0);
  for (var part = 0u; part < PARTS; part++) {
    var sum = Tap();
    var along_x = Tap();
    var along_y = Tap();
    var along_z = Tap();
    for (var k = 0; k < 4; k++) {
      let first = four_taps(here, 0, k, part);
      let second = four_taps(here, 1, k, part);
      let third = four_taps(here, 2, k, part);
      let fourth = four_taps(here, 3, k, part);
      let plane = four_sum(first, x) * y.x + four_sum(second, x) * y.y + four_sum(third, x) * y.z + four_sum(fourth, x) * y.w;
      sum += plane * z[k];
      along_z += plane * dz[k];
      let across = four_sum(first, x) * dy.x + four_sum(second, x) * dy.y + four_sum(third, x) * dy.z + four_sum(fourth, x) * dy.w;
      along_y += across * z[k];
      let rising = four_sum(first, dx) * y.x + four_sum(second, dx) * y.y + four_sum(third, dx) * y.z + four_sum(fourth, dx) * y.w;
      along_x += rising * z[k];
    }
    found += vec3f(slope_of_sum(sum, along_x, part), slope_of_sum(sum, along_y, part), slope_of_sum(sum, along_z, part));
  }
  return found;
}

fn powers(share: f32) -> vec4f { return vec4f(1.0, share, share * share, share * share * share); }

fn slopes(share: f32) -> vec4f { return vec4f(0.0, 1.0, 2.0 * share, 3.0 * share * share); }

// Four voxels along x.
struct FourTaps { a: Tap, b: Tap, c: Tap, d: Tap }

fn four_taps(here: Around, j: i32, k: i32, part: u32) -> FourTaps {
  return FourTaps(
    tap_at(here, vec3i(0, j, k), part), tap_at(here, vec3i(1, j, k), part),
    tap_at(here, vec3i(2, j, k), part), tap_at(here, vec3i(3, j, k), part),
  );
}

fn four_sum(four: FourTaps, x: vec4f) -> Tap { return four.a * x.x + four.b * x.y + four.c * x.z + four.d * x.w; }

fn row_sum(here: Around, j: i32, k: i32, part: u32, x: vec4f) -> Tap { return four_sum(four_taps(here, j, k, part), x); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
