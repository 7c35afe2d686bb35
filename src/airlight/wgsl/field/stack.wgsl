// Interpolation in layers of 2-D textures: across a layer by the texture unit, between two layers in the shader.

import generated::sizes::Values;
import package::field::between::stacked_value;
import package::field::cell::cell_derivative;
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values { return stacked_value(place.p_index); }

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
