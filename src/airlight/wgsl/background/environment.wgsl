// The picture of an environment in the direction of a ray.

import generated::environment::{params, picture, picture_sampler};
import package::ray::Ray;
import slot::lookup::table_at;

const PI = 3.14159265;

fn behind(ray: Ray) -> vec3f {
  let d = params.environment_from_world * ray.direction_world;
  let place = vec2f(atan2(d.x, d.y) / (2.0 * PI) + 0.5, atan2(length(d.xy), d.z) / PI);
  // A column beside each edge is that of the other side.
  let columns = f32(textureDimensions(picture).x);
  return table_at(picture, picture_sampler, vec3f((place.x * (columns - 2.0) + 1.0) / columns, place.y, 0.5)).rgb;
}
