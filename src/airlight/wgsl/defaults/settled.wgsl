// Any value may change the result.

import slot::integrate::Accumulated;

fn settled(acc: ptr<function, Accumulated>, bound: f32, t_world: f32) -> bool { return false; }
