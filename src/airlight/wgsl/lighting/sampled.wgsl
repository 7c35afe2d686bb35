// One evaluation of light for the whole slab, in its middle.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::shade::light;

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  var here = front;
  here.value = 0.5 * (front.value + back.value);
  here.p_index = 0.5 * (front.p_index + back.p_index);
  here.p_world = 0.5 * (front.p_world + back.p_world);
  here.t_world = 0.5 * (front.t_world + back.t_world);
  here.gradient = field_gradient(locate(here.p_index));
  let steepness = length(here.gradient);
  let normal = -here.gradient / max(steepness, 1e-30);
  let lit = light(here, normal, -ray.direction_world);
  return (slab.front_rgb + slab.back_rgb) * lit.diffuse + (slab.front_specular + slab.back_specular) * lit.specular;
}
