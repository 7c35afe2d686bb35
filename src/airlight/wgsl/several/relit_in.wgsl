// The layer whose surface is lit is chosen by its number.

import next::several::relit_in::relit_in as rest_relit_in;
import package::ray::Ray;
import package::relit::relit;

fn relit_in(number: u32, shape: vec4f, side: f32, t_world: f32, ray: Ray) -> vec3f {
  if (number > 0u) { return rest_relit_in(number - 1u, shape, side, t_world, ray); }
  return relit(number, shape, side, t_world, ray);
}
