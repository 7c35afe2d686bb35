// Samples where rays pass planes that lie at equal distances from each other. All rays of a frame pass them in one direction.

import generated::planes::params;
import package::ray::Ray;
import package::spacing::Spacing;

fn spacing_of(ray: Ray, pixel: vec2u) -> Spacing {
  let ahead = params.first - dot(params.normal, ray.origin_world);
  let cosine = dot(params.normal, ray.direction_world);
  return Spacing(params.spacing_world / cosine, ahead / params.spacing_world, select(cosine, 1.0, params.is_measured != 0u));
}
