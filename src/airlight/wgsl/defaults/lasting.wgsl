// Light that is too faint to be seen is none.

fn lasting(light: vec4f) -> bool { return any(light > vec4f(1e-4)); }
