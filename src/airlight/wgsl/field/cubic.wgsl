// Cubic filters over four voxels an axis, whose weights are polynomials of the place within a cell; beyond the faces of the grid
// voxels go on as the outer ones.

import generated::field::{grid, params};
import generated::layer::layer;
import generated::sizes::Values;
import package::field::around::{Around, around};
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let here = around(place.p_index, 2);
  let x = params.basis * powers(here.share.x);
  let y = params.basis * powers(here.share.y);
  let z = params.basis * powers(here.share.z);
  var sum = 0.0;
  for (var k = 0u; k < 4u; k++) { sum += z[k] * dot(y, plane(here, k) * x); }
  return sum * layer.value_scale + layer.value_offset;
}

fn field_derivative(place: Place) -> vec3f {
  let here = around(place.p_index, 2);
  let x = params.basis * powers(here.share.x);
  let y = params.basis * powers(here.share.y);
  let z = params.basis * powers(here.share.z);
  let dx = params.basis * slopes(here.share.x);
  let dy = params.basis * slopes(here.share.y);
  let dz = params.basis * slopes(here.share.z);
  var sum = vec3f(0.0);
  for (var k = 0u; k < 4u; k++) {
    let rows = plane(here, k);
    let along = rows * x;
    sum += vec3f(z[k] * dot(y, rows * dx), z[k] * dot(dy, along), dz[k] * dot(y, along));
  }
  return sum * layer.value_scale;
}

fn powers(share: f32) -> vec4f { return vec4f(1.0, share, share * share, share * share * share); }

fn slopes(share: f32) -> vec4f { return vec4f(0.0, 1.0, 2.0 * share, 3.0 * share * share); }

// Texels of sixteen voxels: a column for each step along x, in it a row for each step along y.
fn plane(here: Around, k: u32) -> mat4x4f {
  return mat4x4f(column(here, 0, i32(k)), column(here, 1, i32(k)), column(here, 2, i32(k)), column(here, 3, i32(k)));
}

fn column(here: Around, i: i32, k: i32) -> vec4f {
  return vec4f(texel(here, vec3i(i, 0, k)), texel(here, vec3i(i, 1, k)), texel(here, vec3i(i, 2, k)), texel(here, vec3i(i, 3, k)));
}

fn texel(here: Around, step: vec3i) -> f32 { return textureLoad(grid, clamp(here.first + step, vec3i(0), here.last), 0).r; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
