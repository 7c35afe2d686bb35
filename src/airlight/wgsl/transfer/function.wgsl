// The transfer function at a value, from its table.

import generated::transfer::{params, function};
import package::sample::Medium;

fn function_at(value: f32) -> Medium {
  let last = f32(params.function_entries - 1u);
  let place = clamp((value - params.first_value) * params.per_value * last, 0.0, last);
  let low = min(u32(place), params.function_entries - 2u);
  let a = textureLoad(function, vec3u(low, 0u, 0u), 0);
  let b = textureLoad(function, vec3u(low + 1u, 0u, 0u), 0);
  let texel = mix(a, b, place - f32(low));
  return Medium(texel.rgb, texel.a);
}

// Whether the function holds nothing between two values, because both lie on its empty first or last stretch.
fn is_empty_between(s_front: f32, s_back: f32) -> bool {
  return max(s_front, s_back) <= params.empty_below || min(s_front, s_back) >= params.empty_above;
}

// Source term [1/world] of a medium.
fn source_of(here: Medium) -> vec3f {
  return here.rgb * select(here.extinction, 1.0, params.associated != 0u);
}
