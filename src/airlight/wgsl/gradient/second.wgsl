// The second derivative along the gradient, in the world (Kindlmann and Durkin, section 3.2), from the differences of
// `transfer/derivatives.py`: straight on beyond faces and beside empty samples.

import generated::layer::layer;
import generated::sizes::HAS_EMPTY;
import package::empty::is_empty;
import slot::field::{locate, field_scalar};

// [data/world^2] of the field at a point, along its gradient there [data/world].
fn second_along(p_index: vec3f, gradient_world: vec3f) -> f32 {
  let squared = dot(gradient_world, gradient_world);
  if (squared <= 0.0) { return 0.0; }
  let way = (layer.index_from_world * vec4f(gradient_world * inverseSqrt(squared), 0.0)).xyz;
  var sum = 0.0;
  for (var i = 0u; i < 3u; i++) {
    let j = (i + 1u) % 3u;
    sum += way[i] * way[i] * bend(p_index, axis(i)) + 2.0 * way[i] * way[j] * twist(p_index, axis(i), axis(j));
  }
  return sum;
}

fn axis(i: u32) -> vec3f { return select(vec3f(0.0), vec3f(1.0), vec3u(0u, 1u, 2u) == vec3u(i)); }

// Second difference along an index axis [data/voxel^2]. Less than a voxel from a face it is that of a voxel away, and less and less
// of it: none at the face.
fn bend(p_index: vec3f, along: vec3f) -> f32 {
  let p = dot(p_index, along);
  let low = dot(layer.domain_low, along) + 1.0;
  let high = dot(layer.domain_high, along) - 1.0;
  let aside = clamp(p, low, high) - p;
  let middle = p_index + along * aside;
  let here = field_scalar(locate(middle));
  let ends = vec2f(field_scalar(locate(middle - along)), field_scalar(locate(middle + along)));
  if (high < low || (HAS_EMPTY && (is_empty(ends.x) || is_empty(ends.y) || is_empty(here)))) { return 0.0; }
  return (ends.x + ends.y - 2.0 * here) * saturate(1.0 - abs(aside));
}

// Mixed second difference along two index axes [data/voxel^2], shortened at faces.
fn twist(p_index: vec3f, along: vec3f, across: vec3f) -> f32 {
  let low = max(p_index - along - across, layer.domain_low);
  let high = min(p_index + along + across, layer.domain_high);
  let span = high - low;
  let area = dot(span, along) * dot(span, across);
  let a = field_scalar(locate(low));
  let b = field_scalar(locate(high));
  let c = field_scalar(locate(low + along * dot(span, along)));
  let d = field_scalar(locate(low + across * dot(span, across)));
  if (HAS_EMPTY && (is_empty(a) || is_empty(b) || is_empty(c) || is_empty(d))) { return 0.0; }
  return (a + b - c - d) / area;
}
