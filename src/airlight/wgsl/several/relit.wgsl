// Light on a surface of one of several layers.

import next::several::relit_in::relit_in;
import package::ray::Ray;

fn relit(number: u32, shape: vec4f, side: f32, t_world: f32, ray: Ray) -> vec3f {
  return relit_in(number, shape, side, t_world, ray);
}
