// Media that were made of the voxels, interpolated in layers of 2-D textures; the samples themselves for gradients.

import generated::field::{BETWEEN, classified, classified_sampler};
import generated::sizes::Values;
import package::field::between::{between_layers, stacked_value};
import package::ray::INFINITE;
import slot::lookup::layer_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let here = between_layers(place.p_index);
  var medium = layer_at(classified, classified_sampler, here.p_unit, here.low);
  if (BETWEEN) { medium = mix(medium, layer_at(classified, classified_sampler, here.p_unit, here.high), here.share); }
  return Values(medium);
}

fn field_scalar(place: Place) -> f32 { return stacked_value(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
