// One evaluation of light for the whole slab, at its back sample.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::shade::light;

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  var here = back;
  here.gradient = field_gradient(locate(here.p_index));
  let steepness = length(here.gradient);
  let normal = -here.gradient / max(steepness, 1e-30);
  let lit = light(here, normal, -ray.direction_world);
  return (slab.front_rgb + slab.back_rgb) * lit.diffuse + (slab.front_specular + slab.back_specular) * lit.specular;
}
