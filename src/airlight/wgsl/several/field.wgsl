// Several layers have no field of their own.

struct Place { nothing: f32 }

fn locate(p_world: vec3f) -> Place { return Place(0.0); }
