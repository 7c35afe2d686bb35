// How samples are lit by their gradients, and slabs by a sample inside them.

import package::ray::Ray;
import package::sample::{Sample, Slab, Lit};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::shade::light;
import slot::values::mix_values;

// A sample whose gradient is known, seen along a ray.
fn lit_by_gradient(here: Sample, ray: Ray) -> Lit {
  // Scaled first, since squares of very large and very small gradients do not fit into 32 bits.
  let steepest = max(abs(here.gradient.x), max(abs(here.gradient.y), abs(here.gradient.z)));
  let scaled = here.gradient / max(steepest, 1e-37);
  let normal = -scaled / max(length(scaled), 1e-3);
  return light(here, normal, -ray.direction_world);
}

fn gradient_at(here: Sample) -> vec3f { return field_gradient(locate(here.p_index)); }

// The sample at a share of a slab, 0 at the front, 1 at the back; its gradient is the front's.
fn between_ends(front: Sample, back: Sample, share: f32) -> Sample {
  return Sample(
    mix_values(front.value, back.value, share),
    front.gradient,
    mix(front.p_index, back.p_index, share),
    mix(front.p_world, back.p_world, share),
    mix(front.t_world, back.t_world, share),
  );
}

fn lit_at(front: Sample, back: Sample, share: f32, slab: Slab, ray: Ray) -> vec3f {
  var here = between_ends(front, back, share);
  here.gradient = gradient_at(here);
  return lit_whole(slab, lit_by_gradient(here, ray));
}

// A slab that is lit everywhere alike.
fn lit_whole(slab: Slab, lit: Lit) -> vec3f {
  return (slab.front_rgb + slab.back_rgb) * lit.diffuse + (slab.front_specular + slab.back_specular) * lit.specular;
}

// A slab whose two ends are lit each by itself.
fn lit_ends(slab: Slab, near: Lit, far: Lit) -> vec3f {
  return slab.front_rgb * near.diffuse + slab.front_specular * near.specular
    + slab.back_rgb * far.diffuse + slab.back_specular * far.specular;
}
