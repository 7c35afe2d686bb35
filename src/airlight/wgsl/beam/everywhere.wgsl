// A light that shines into all directions alike.

fn picture_at(p_world: vec3f) -> vec3f { return vec3f(1.0); }
