// Light at both ends of a slab, each with its part of the slab's colour (Lum, Wilson and Ma, section 3). In a march there is one
// evaluation a sample: the back of a slab is the front of the next.

import package::ray::Ray;
import package::sample::{Sample, Slab, Lit};
import package::lighting::at_share::{gradient_at, lit_by_gradient, lit_ends};

struct LitEnd { lit: Lit }

fn know_light(here: Sample, ray: Ray) -> LitEnd {
  var end = here;
  end.gradient = gradient_at(here);
  return LitEnd(lit_by_gradient(end, ray));
}

fn light_known(front: Sample, front_light: LitEnd, back: Sample, back_light: LitEnd, slab: Slab, ray: Ray) -> vec3f {
  return lit_ends(slab, front_light.lit, back_light.lit);
}

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  return light_known(front, know_light(front, ray), back, know_light(back, ray), slab, ray);
}
