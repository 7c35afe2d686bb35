// What a slab takes from the eye it takes from all colours of a light.

import package::sample::Slab;

fn passing(slab: Slab) -> vec4f { return vec4f(1.0 - slab.alpha); }
