// What comes through of one light to a place among the planes of a group that it has passed. Ambient light counts in one sweep alone.

import generated::lamp::params as lamp;
import generated::pass::{light_planes, light_planes_sampler};
import generated::visibility::GREY;
import package::light_place::place_in_light;
import slot::beam::picture_at;
import slot::transport::comes_through;

fn visibility(light_index: u32, p_world: vec3f) -> vec3f {
  let texels = f32(textureDimensions(light_planes).x);
  let behind = (dot(lamp.normal, p_world) - lamp.first) * lamp.per_world;
  var texel = clamp(behind, 0.0, texels - 1.0);
  if (GREY) { texel = clamp(floor(behind / 3.0), 0.0, texels - 1.0); }
  let place = vec3f((texel + 0.5) / texels, place_in_light(p_world));
  var light = textureSampleLevel(light_planes, light_planes_sampler, place, 0.0);
  if (GREY) {
    // Four planes in a row.
    let at = clamp(behind - 3.0 * texel, 0.0, 3.0);
    light = vec4f(dot(light, saturate(1.0 - abs(at - vec4f(0.0, 1.0, 2.0, 3.0)))));
  }
  return comes_through(light, picture_at(p_world));
}

fn ambient_visibility(p_world: vec3f) -> f32 { return lamp.ambient; }
