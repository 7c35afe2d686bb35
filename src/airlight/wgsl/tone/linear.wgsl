// The radiance as it is, brighter or darker.

import generated::tone::params;

fn tone(rgb: vec3f, p_px: vec2f) -> vec3f { return rgb * exp2(params.exposure); }
