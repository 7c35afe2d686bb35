// Trilinear interpolation, by the texture unit, of values and gradients in one texture: a place knows both.

import generated::field::{gradients, gradients_sampler, params};
import generated::layer::layer;
import package::ray::INFINITE;
import generated::sizes::Values;

struct Place { p_index: vec3f, gradient: vec3f, value: f32 }

fn locate(p_index: vec3f) -> Place {
  let texel = textureSampleLevel(gradients, gradients_sampler, (p_index + 0.5) * layer.inverse_size, 0.0);
  return Place(p_index, texel.xyz * params.scale, texel.w * params.value_scale + params.value_offset);
}

fn field_value(place: Place) -> Values { return place.value; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
