// What a picture leaves of pixels to an environment behind it.

import generated::backdrop::params;
import generated::pass::radiance;
import package::picture::place;

fn pixel(p_px: vec2i) -> f32 { return params.seen * (1.0 - radiance[place(p_px)].a); }
