// Media that were made of the voxels, interpolated; the samples themselves for gradients.

import generated::layer::layer;
import generated::preclassified::{grid, grid_sampler, classified, classified_sampler};
import generated::sizes::Values;
import package::ray::INFINITE;
import slot::lookup::table_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  return Values(table_at(classified, classified_sampler, unit(place)));
}

fn field_scalar(place: Place) -> f32 {
  return textureSampleLevel(grid, grid_sampler, unit(place), 0.0).r * layer.value_scale + layer.value_offset;
}

fn unit(place: Place) -> vec3f { return (place.p_index + 0.5) * layer.inverse_size; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
