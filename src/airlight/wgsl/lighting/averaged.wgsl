// One evaluation of light for each slab, by the mean of the gradients at its two ends (Engel and Ertl, section 7).

import package::ray::Ray;
import package::sample::{Sample, Slab};
import package::lighting::at_share::{between_ends, gradient_at, lit_by_gradient, lit_whole};

struct LitEnd { gradient: vec3f }

fn know_light(here: Sample, ray: Ray) -> LitEnd { return LitEnd(gradient_at(here)); }

fn light_known(front: Sample, front_light: LitEnd, back: Sample, back_light: LitEnd, slab: Slab, ray: Ray) -> vec3f {
  var middle = between_ends(front, back, 0.5);
  middle.gradient = 0.5 * (front_light.gradient + back_light.gradient);
  return lit_whole(slab, lit_by_gradient(middle, ray));
}

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  return light_known(front, know_light(front, ray), back, know_light(back, ray), slab, ray);
}
