// A slab lets more through of its own colour (Kniss, Kindlmann and Hansen 2002).

import generated::coloured::params;
import package::sample::Slab;
import package::transport::colours::let_through;

fn passing(slab: Slab) -> vec4f { return vec4f(let_through(slab, params.tint), 1.0 - slab.alpha); }
