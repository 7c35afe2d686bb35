// Trilinear interpolation on pre-filtered levels, chosen by the width of a pixel at the place, and between them.

import generated::field::params;
import generated::layer::layer;
import generated::sizes::Values;
import package::ray::INFINITE;
import slot::voxels::level_at;

struct Place { p_index: vec3f, level: f32 }

fn locate(p_index: vec3f) -> Place {
  let distance_world = length(params.world_from_index * (p_index - params.eye_index));
  let width = params.width_at_eye + params.width_per_world * distance_world;
  return Place(p_index, clamp(log2(max(width, 1e-20)) + params.bias, 0.0, params.coarsest));
}

fn field_value(place: Place) -> Values {
  let p_unit = (place.p_index + 0.5) * layer.inverse_size;
  return level_at(p_unit, place.level).r * layer.value_scale + layer.value_offset;
}

// At the level of the place: how levels change from place to place is left out.
fn field_derivative(place: Place) -> vec3f {
  let fine = floor(place.level);
  let coarse = min(fine + 1.0, params.coarsest);
  let slopes = mix(level_slopes(place.p_index, fine), level_slopes(place.p_index, coarse), place.level - fine);
  return slopes * layer.value_scale;
}

// Differences across the cell of a level, per voxel of the finest; none beyond the centres of its outer samples. By the texture
// unit: lavapipe loads texels of one level only for all pixels that it computes side by side.
fn level_slopes(p_index: vec3f, level: f32) -> vec3f {
  let size = max(floor(layer.size / f32(1u << u32(level))), vec3f(1.0));
  let last = size - 1.0;
  let p_level = select((p_index + 0.5) * (size * layer.inverse_size) - 0.5, p_index, level == 0.0);
  let p = clamp(p_level, vec3f(0.0), last);
  let low = min(floor(p), max(last - 1.0, vec3f(0.0)));
  var slopes: vec3f;
  for (var axis = 0u; axis < 3u; axis++) {
    let along = vec3u(axis) == vec3u(0u, 1u, 2u);
    slopes[axis] = fetched(select(p, low + 1.0, along), size, level) - fetched(select(p, low, along), size, level);
  }
  return select(slopes * size * layer.inverse_size, vec3f(0.0), abs(p_level - p) > vec3f(1e-3));
}

fn fetched(p_level: vec3f, size: vec3f, level: f32) -> f32 { return level_at((p_level + 0.5) / size, level).r; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
