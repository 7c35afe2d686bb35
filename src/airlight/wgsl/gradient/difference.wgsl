// Differences of the field over one voxel to each side, shortened at the faces of the domain and at empty samples.

import slot::field::{locate, field_scalar};
import generated::layer::layer;
import generated::sizes::HAS_EMPTY;
import package::empty::is_empty;

// Derivative along an index axis, given as a unit vector [data/voxel].
fn difference(p_index: vec3f, axis: vec3f) -> f32 { return known_difference(p_index, axis).x; }

// The derivative, and 1 where it is known: there is none at an empty sample.
fn known_difference(p_index: vec3f, axis: vec3f) -> vec2f {
  var low = max(p_index - axis, layer.domain_low);
  var high = min(p_index + axis, layer.domain_high);
  var value_low = field_scalar(locate(low));
  var value_high = field_scalar(locate(high));
  if (HAS_EMPTY) {
    let value_here = field_scalar(locate(p_index));
    if (is_empty(value_low)) { low = p_index; value_low = value_here; }
    if (is_empty(value_high)) { high = p_index; value_high = value_here; }
    if (is_empty(value_here)) { return vec2f(0.0); }
  }
  let width = dot(high - low, axis);
  return vec2f(select(0.0, (value_high - value_low) / width, width > 1e-6), 1.0);
}

// Gradient in the world [data/world] of one in index coordinates [data/voxel].
fn gradient_world(gradient_index: vec3f) -> vec3f { return layer.gradient_world_from_index * gradient_index; }
