// Trilinear interpolation by the texture unit.

import generated::layer::layer;
import package::field::cell::cell_derivative;
import package::ray::INFINITE;
import generated::sizes::Values;
import slot::voxels::sample_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values { return sample_at(place.p_index).r * layer.value_scale + layer.value_offset; }

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
