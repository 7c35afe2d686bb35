// What a ray meets of a triangle of a mesh, in its light.

import generated::mesh::params;
import package::cover::Cover;
import package::ray::Ray;
import package::sample::Sample;
import package::triangle::{colour_of, normal_of, point_of, shares_of, triangle_of};
import slot::shade::light;

fn lit_triangle(number: u32, ray: Ray) -> Cover {
  let triangle = triangle_of(number);
  let share = shares_of(triangle, ray);
  var here: Sample;
  here.p_world = point_of(triangle, share);
  here.t_world = dot(here.p_world - ray.origin_world, ray.direction_world);
  let rgba = vec4f(params.rgb, params.opacity) * colour_of(triangle, share);
  let alpha = select(rgba.a, 1.0, params.is_opaque != 0u);
  let normal = normal_of(triangle, share);
  here.gradient = -normal;
  let lit = light(here, normal, -ray.direction_world);
  let rgb = select(rgba.rgb, rgba.rgb * lit.diffuse + lit.specular, params.is_lit != 0u);
  return Cover(alpha * rgb, alpha, here.t_world);
}
