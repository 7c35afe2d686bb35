// A slab is lit in its middle.

import package::sample::{Sample, Slab};

fn lit_share(front: Sample, back: Sample, slab: Slab) -> f32 { return 0.5; }
