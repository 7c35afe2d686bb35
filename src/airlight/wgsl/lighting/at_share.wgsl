// A slab lit as it is lit at one place inside it.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::shade::light;
import slot::values::mix_values;

// `share` is 0 at the front, 1 at the back.
fn lit_at(front: Sample, back: Sample, share: f32, slab: Slab, ray: Ray) -> vec3f {
  let p_index = mix(front.p_index, back.p_index, share);
  let here = Sample(
    mix_values(front.value, back.value, share),
    field_gradient(locate(p_index)),
    p_index,
    mix(front.p_world, back.p_world, share),
    mix(front.t_world, back.t_world, share),
  );
  // Scaled first, since squares of very large and very small gradients do not fit into 32 bits.
  let steepest = max(abs(here.gradient.x), max(abs(here.gradient.y), abs(here.gradient.z)));
  let scaled = here.gradient / max(steepest, 1e-37);
  let normal = -scaled / max(length(scaled), 1e-3);
  let lit = light(here, normal, -ray.direction_world);
  return (slab.front_rgb + slab.back_rgb) * lit.diffuse + (slab.front_specular + slab.back_specular) * lit.specular;
}
