// Filters whose weights along each axis come from a table by the share of the way through a cell: a row for each two voxels, in it
// their weights, then the derivatives of these. Beyond the faces of the grid voxels go on as the outer ones.
// Voxels are taken eight at a time, two along each axis: some drivers bound the turns of all loops together. How many there are is told
// by the table: Mesa 22.3 (lavapipe) compiles a loop that ends by a uniform anew for each dispatch.

import generated::field::weights;
import generated::sizes::Values;
import package::field::around::{Around, around, tap_at};
import package::ray::INFINITE;
import slot::taps::{PARTS, Tap, keep_sum, scalar_in, slope_of_sum};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let count = pair_count();
  let here = around(place.p_index, i32(count));
  var values: Values;
  for (var part = 0u; part < PARTS; part++) {
    var sum = Tap();
    for (var k = 0u; k < count; k++) {
      let z = pair(here.share.z, k);
      for (var j = 0u; j < count; j++) {
        let y = pair(here.share.y, j);
        for (var i = 0u; i < count; i++) {
          let voxels = eight(here, vec3u(i, j, k), part);
          sum += across(along(voxels, pair(here.share.x, i).xy), y.xy, z.xy);
        }
      }
    }
    keep_sum(sum, part, &values);
  }
  return values;
}

fn field_scalar(place: Place) -> f32 { return scalar_in(field_value(place)); }

fn field_derivative(place: Place) -> vec3f {
  let count = pair_count();
  let here = around(place.p_index, i32(count));
  var found = vec3f(0.0);
  for (var part = 0u; part < PARTS; part++) {
    var sum = Tap();
    var along_x = Tap();
    var along_y = Tap();
    var along_z = Tap();
    for (var k = 0u; k < count; k++) {
      let z = pair(here.share.z, k);
      for (var j = 0u; j < count; j++) {
        let y = pair(here.share.y, j);
        for (var i = 0u; i < count; i++) {
          let x = pair(here.share.x, i);
          let voxels = eight(here, vec3u(i, j, k), part);
          let rows = along(voxels, x.xy);
          sum += across(rows, y.xy, z.xy);
          along_x += across(along(voxels, x.zw), y.xy, z.xy);
          along_y += across(rows, y.zw, z.xy);
          along_z += across(rows, y.xy, z.zw);
        }
      }
    }
    found += vec3f(slope_of_sum(sum, along_x, part), slope_of_sum(sum, along_y, part), slope_of_sum(sum, along_z, part));
  }
  return found;
}

fn pair_count() -> u32 { return textureDimensions(weights).y; }

// Weights and derivatives of two voxels along an axis.
fn pair(share: f32, number: u32) -> vec4f {
  let last = textureDimensions(weights).x - 1u;
  let place = share * f32(last);
  let low = min(u32(place), last - 1u);
  let at = vec3u(low, number, 0u);
  return mix(textureLoad(weights, at, 0), textureLoad(weights, at + vec3u(1u, 0u, 0u), 0), place - f32(low));
}

// Two voxels along x in four rows: two along y, then those of the next slice.
struct Rows { a: Tap, b: Tap, c: Tap, d: Tap }
struct Eight { left: Rows, right: Rows }

fn eight(here: Around, pairs: vec3u, part: u32) -> Eight {
  let at = 2 * vec3i(pairs);
  return Eight(rows_at(here, at, part), rows_at(here, at + vec3i(1, 0, 0), part));
}

fn rows_at(here: Around, at: vec3i, part: u32) -> Rows {
  return Rows(
    tap_at(here, at, part), tap_at(here, at + vec3i(0, 1, 0), part),
    tap_at(here, at + vec3i(0, 0, 1), part), tap_at(here, at + vec3i(0, 1, 1), part),
  );
}

fn along(voxels: Eight, x: vec2f) -> Rows {
  let l = voxels.left;
  let r = voxels.right;
  return Rows(l.a * x.x + r.a * x.y, l.b * x.x + r.b * x.y, l.c * x.x + r.c * x.y, l.d * x.x + r.d * x.y);
}

fn across(rows: Rows, y: vec2f, z: vec2f) -> Tap {
  return (rows.a * y.x + rows.b * y.y) * z.x + (rows.c * y.x + rows.d * y.y) * z.y;
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
