// Nothing is kept of how a sample is lit: a slab is lit as a whole.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::lighting::light_slab;

struct LitEnd { nothing: f32 }

fn know_light(here: Sample, ray: Ray) -> LitEnd { return LitEnd(0.0); }

fn light_known(front: Sample, front_light: LitEnd, back: Sample, back_light: LitEnd, slab: Slab, ray: Ray) -> vec3f {
  return light_slab(front, back, slab, ray);
}
