// The light's buffer as it was at the plane before, interpolated by hand: not all devices filter 32-bit floats.

import generated::pass::light_before;
import package::light_kept::light_in;
import package::light_place::place_in_light;

fn light_at(p_world: vec3f) -> vec4f {
  let size = vec2f(textureDimensions(light_before));
  let place = place_in_light(p_world) * size - 0.5;
  let low = floor(place);
  let share = place - low;
  let upper = mix(kept_at(low, size), kept_at(low + vec2f(1.0, 0.0), size), share.x);
  let lower = mix(kept_at(low + vec2f(0.0, 1.0), size), kept_at(low + 1.0, size), share.x);
  return mix(upper, lower, share.y);
}

fn kept_at(place: vec2f, size: vec2f) -> vec4f {
  return light_in(textureLoad(light_before, vec2u(clamp(place, vec2f(0.0), size - 1.0)), 0));
}
