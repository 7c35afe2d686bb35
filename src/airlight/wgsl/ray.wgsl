// Rays, in the world.

struct Ray { origin_world: vec3f, direction_world: vec3f }  // direction of length one

const INFINITE: f32 = 3.4e38;
