// Two evaluations of light for each slab, at the nodes of Gauss' rule.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import package::lighting::at_share::lit_at;

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  return 0.5 * (lit_at(front, back, 0.2113249, slab, ray) + lit_at(front, back, 0.7886751, slab, ray));
}
