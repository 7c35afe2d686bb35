// Light on the surface of a layer that a march has found: see `hits/kept.wgsl`.

import generated::layer::layer;
import generated::sizes::Values;
import package::lighting::at_share::{lit_by_gradient, lit_whole};
import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::integrate::surface_rgb;
import slot::region::part_at;
import slot::transfer::medium;
import slot::values::with_scalar;

// `shape` is gradient and value, `side` which one was met; `number` is that of the layer.
fn relit(number: u32, shape: vec4f, side: f32, t_world: f32, ray: Ray) -> vec3f {
  let p_world = ray.origin_world + t_world * ray.direction_world;
  let p_index = (layer.index_from_world * vec4f(p_world, 1.0)).xyz;
  var value: Values;
  let here = Sample(with_scalar(value, shape.w), shape.xyz, p_index, p_world, t_world);
  var near = here;
  var far = here;
  near.value = with_scalar(value, 0.0);
  far.value = with_scalar(value, select(1.0, -1.0, side == 2.0));
  var rgb = medium(here).rgb;
  if (side < 3.0) { rgb = surface_rgb(here, near, far, rgb); }
  let slab = Slab(rgb * part_at(p_index).rgb, 1.0, vec3f(0.0), 0.0, 1.0);
  return lit_whole(slab, lit_by_gradient(here, ray));
}
