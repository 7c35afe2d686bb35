// Rays, in the world.

struct Ray { origin_world: vec3f, direction_world: vec3f }  // direction of length one, or zero: nothing is seen

const INFINITE: f32 = 3.4e38;
