// Media that were made of the voxels, interpolated; the samples themselves for gradients.

import generated::field::{classified, classified_sampler};
import generated::layer::layer;
import generated::sizes::Values;
import package::ray::INFINITE;
import slot::voxels::{made_at, sample_at};

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values { return Values(made_at(classified, classified_sampler, place.p_index)); }

fn field_scalar(place: Place) -> f32 { return sample_at(place.p_index).r * layer.value_scale + layer.value_offset; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
