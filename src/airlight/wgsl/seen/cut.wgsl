// What clips cut away of meshes: told where the pixel's ray meets the triangle itself.

import generated::frame::frame;
import package::corner::Corner;
import package::ray::INFINITE;
import package::triangle::{point_of, shares_of, triangle_of};
import slot::camera::eye_ray;
import slot::clips::kept_from;

fn is_cut(at: Corner) -> bool {
  let pixel = frame.tile_origin_px + vec2u(at.place.xy);
  let ray = eye_ray(vec2f(pixel) + 0.5);
  let triangle = triangle_of(at.triangle);
  let t_world = dot(point_of(triangle, shares_of(triangle, ray)) - ray.origin_world, ray.direction_world);
  let in_band = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  return kept_from(ray, in_band, t_world, INFINITE).begin > t_world;
}
