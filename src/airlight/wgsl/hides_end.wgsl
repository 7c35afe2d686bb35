// Nothing hides behind the last layer.

fn depth_along(p_cell: vec3f, way: vec3f, most: f32, way_world: f32) -> vec3f { return vec3f(0.0); }

fn depth_round(p_cell: vec3f, way: vec3f, begin_world: f32) -> f32 { return 0.0; }
