// Light between cells, which have one more all round them: places are counted in cells, from the corner of the volume.

import generated::shadow::params as shadow;

fn middle_of(texel: vec3u) -> vec3f { return vec3f(texel) - 0.5; }

fn to_light(p_cell: vec3f) -> vec3f { return shadow.light.xyz - shadow.light.w * p_cell; }
