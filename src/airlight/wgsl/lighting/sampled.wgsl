// One evaluation of light for the whole slab: in its middle, or where the transfer stage says that its light comes from.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import package::lighting::at_share::lit_at;
import slot::transfer::lit_share;

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  return lit_at(front, back, lit_share(front, back, slab), slab, ray);
}
