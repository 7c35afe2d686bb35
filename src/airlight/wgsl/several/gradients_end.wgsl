// No gradient behind the last layer.

import package::several::layer_end::Lines;

struct Dense { alpha: f32, number: u32 }

fn gradient_of_layer(lines: Lines, number: u32, clip: u32, t_world: f32) -> vec3f { return vec3f(0.0); }

fn densest(lines: Lines, t_world: f32) -> Dense { return Dense(-1.0, 0u); }
