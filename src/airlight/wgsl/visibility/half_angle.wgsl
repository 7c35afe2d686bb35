// What comes through of one light to a place among the planes of a group that it has passed. Ambient light counts in one sweep alone.

import generated::lamp::params as lamp;
import generated::pass::{light_planes, light_planes_sampler};
import package::light_place::place_in_light;
import slot::beam::picture_at;
import slot::transport::comes_through;

fn visibility(light_index: u32, p_world: vec3f) -> vec3f {
  let count = f32(textureDimensions(light_planes).z);
  let plane = clamp((dot(lamp.normal, p_world) - lamp.first) * lamp.per_world, 0.0, count - 1.0);
  let place = vec3f(place_in_light(p_world), (plane + 0.5) / count);
  return comes_through(textureSampleLevel(light_planes, light_planes_sampler, place, 0.0), picture_at(p_world));
}

fn ambient_visibility(p_world: vec3f) -> f32 { return lamp.ambient; }
