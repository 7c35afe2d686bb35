// The slab keeps its own colour.

import package::ray::Ray;
import package::sample::{Sample, Slab};

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f { return slab.front_rgb + slab.back_rgb; }
