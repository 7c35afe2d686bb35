// No surface behind the last layer.

import package::ray::Ray;

fn relit_in(number: u32, shape: vec4f, side: f32, t_world: f32, ray: Ray) -> vec3f { return vec3f(0.0); }
