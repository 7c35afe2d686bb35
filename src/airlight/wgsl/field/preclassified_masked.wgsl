// Media of the voxels that are there, their weights normalised; empty where they have less than half.

import generated::field::classified;
import generated::layer::layer;
import generated::sizes::Values;
import package::empty::{EMPTY, is_empty};
import package::ray::INFINITE;
import slot::voxels::{made_texel_at, texel_at};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let cell = cell_at(place.p_index);
  var sum = vec4f(0.0);
  var there = 0.0;
  for (var corner = 0u; corner < 8u; corner++) {
    let medium = made_texel_at(classified, voxel_of(cell, corner));
    if (!is_empty(medium.a)) {
      sum += medium * weight_of(cell, corner);
      there += weight_of(cell, corner);
    }
  }
  return Values(select(sum / max(there, 1e-30), vec4f(EMPTY), there < 0.5));
}

fn field_scalar(place: Place) -> f32 {
  let cell = cell_at(place.p_index);
  var sum = vec2f(0.0);
  for (var corner = 0u; corner < 8u; corner++) {
    let value = texel_at(voxel_of(cell, corner)).r;
    if (!is_empty(value)) { sum += vec2f(value, 1.0) * weight_of(cell, corner); }
  }
  return select(sum.x / max(sum.y, 1e-30), EMPTY, sum.y < 0.5);
}

// The voxel below a point along each axis, and how far the point is on its way to the next.
struct Cell { low: vec3f, share: vec3f }

fn cell_at(p_index: vec3f) -> Cell {
  let p = clamp(p_index, vec3f(0.0), layer.size - 1.0);
  return Cell(floor(p), fract(p));
}

fn high_of(corner: u32) -> vec3f { return vec3f(vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u)); }

fn voxel_of(cell: Cell, corner: u32) -> vec3i { return vec3i(min(cell.low + high_of(corner), layer.size - 1.0)); }

fn weight_of(cell: Cell, corner: u32) -> f32 {
  let share = mix(1.0 - cell.share, cell.share, high_of(corner));
  return share.x * share.y * share.z;
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
