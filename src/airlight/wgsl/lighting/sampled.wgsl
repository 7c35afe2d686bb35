// One evaluation of light for the whole slab, in its middle.

import package::ray::Ray;
import package::sample::{Sample, Slab};
import package::lighting::at_share::lit_at;

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f { return lit_at(front, back, 0.5, slab, ray); }
