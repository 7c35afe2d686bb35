// Nothing is hidden.

fn hidden_at(p_index: vec3f) -> bool { return false; }
