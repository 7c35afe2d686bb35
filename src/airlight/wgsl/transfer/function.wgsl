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

// Whether both values lie on one of the (at most four) stretches on which the function holds nothing.
fn is_empty_between(s_front: f32, s_back: f32) -> bool {
  let low = vec4f(min(s_front, s_back));
  let high = vec4f(max(s_front, s_back));
  return any((low >= params.empty_low) & (high <= params.empty_high));
}

// Source term [1/world] of a medium.
fn source_of(here: Medium) -> vec3f {
  return here.rgb * select(here.extinction, 1.0, params.associated != 0u);
}
