// Filters whose weights along each axis come from a table by the share of the way through a cell: a row for each two voxels, in it
// their weights, then the derivatives of these. Beyond the faces of the grid voxels go on as the outer ones.
// Voxels are taken eight at a time, two along each axis: some drivers bound the turns of all loops together.

import generated::field::{grid, params, weights};
import generated::layer::layer;
import generated::sizes::Values;
import package::field::around::{Around, around};
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let here = around(place.p_index, i32(params.pairs));
  var sum = 0.0;
  for (var k = 0u; k < params.pairs; k++) {
    let z = pair(here.share.z, k).xy;
    for (var j = 0u; j < params.pairs; j++) {
      let y = pair(here.share.y, j).xy;
      for (var i = 0u; i < params.pairs; i++) {
        let rows = four_rows(here, vec3u(i, j, k)) * pair(here.share.x, i).xy;
        sum += dot(z, vec2f(dot(rows.xy, y), dot(rows.zw, y)));
      }
    }
  }
  return sum * layer.value_scale + layer.value_offset;
}

fn field_derivative(place: Place) -> vec3f {
  let here = around(place.p_index, i32(params.pairs));
  var sum = vec3f(0.0);
  for (var k = 0u; k < params.pairs; k++) {
    let z = pair(here.share.z, k);
    for (var j = 0u; j < params.pairs; j++) {
      let y = pair(here.share.y, j);
      for (var i = 0u; i < params.pairs; i++) {
        let x = pair(here.share.x, i);
        let voxels = four_rows(here, vec3u(i, j, k));
        let along = voxels * x.xy;
        let slope = voxels * x.zw;
        sum.x += dot(z.xy, vec2f(dot(slope.xy, y.xy), dot(slope.zw, y.xy)));
        sum.y += dot(z.xy, vec2f(dot(along.xy, y.zw), dot(along.zw, y.zw)));
        sum.z += dot(z.zw, vec2f(dot(along.xy, y.xy), dot(along.zw, y.xy)));
      }
    }
  }
  return sum * layer.value_scale;
}

// Weights and derivatives of two voxels along an axis.
fn pair(share: f32, number: u32) -> vec4f {
  let last = textureDimensions(weights).x - 1u;
  let place = share * f32(last);
  let low = min(u32(place), last - 1u);
  let at = vec3u(low, number, 0u);
  return mix(textureLoad(weights, at, 0), textureLoad(weights, at + vec3u(1u, 0u, 0u), 0), place - f32(low));
}

// Texels of two voxels along x, one to a column, in four rows: two along y, then those of the next slice.
fn four_rows(here: Around, pairs: vec3u) -> mat2x4f {
  let at = here.first + 2 * vec3i(pairs);
  return mat2x4f(column(here, at), column(here, at + vec3i(1, 0, 0)));
}

fn column(here: Around, at: vec3i) -> vec4f {
  return vec4f(
    texel(here, at), texel(here, at + vec3i(0, 1, 0)), texel(here, at + vec3i(0, 0, 1)), texel(here, at + vec3i(0, 1, 1)),
  );
}

fn texel(here: Around, voxel: vec3i) -> f32 { return textureLoad(grid, clamp(voxel, vec3i(0), here.last), 0).r; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
