// A light that throws a picture; beside it there is none.

import generated::lamp::params as lamp;
import generated::pass::{light_picture, light_picture_sampler};

fn picture_at(p_world: vec3f) -> vec3f {
  let place = lamp.picture_from_world * vec4f(p_world, 1.0);
  let unit = vec2f(0.5, -0.5) * (place.xy / max(place.w, 1e-30)) + 0.5;
  let inside = place.w > 0.0 && all(unit >= vec2f(0.0)) && all(unit <= vec2f(1.0));
  return textureSampleLevel(light_picture, light_picture_sampler, unit, 0.0).rgb * f32(inside);
}
