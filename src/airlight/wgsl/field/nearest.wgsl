// The value of the nearest voxel.

import generated::nearest::grid;
import generated::layer::layer;
import package::ray::INFINITE;
import generated::sizes::Values;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let voxel = clamp(floor(place.p_index + 0.5), vec3f(0.0), layer.size - 1.0);
  return textureLoad(grid, vec3i(voxel), 0).r * layer.value_scale + layer.value_offset;
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
