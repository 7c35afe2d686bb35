// Where the rays of a light pass its buffer, from (0, 0) in the upper left corner to (1, 1).

import generated::lamp::params as lamp;

fn place_in_light(p_world: vec3f) -> vec2f {
  let place = lamp.light_from_world * vec4f(p_world, 1.0);
  return vec2f(0.5, -0.5) * (place.xy / place.w) + 0.5;
}
