// What is kept of a ray between two parts: all that was accumulated.

import slot::integrate::Accumulated;

struct Paused { acc: Accumulated }

fn pause(acc: Accumulated) -> Paused { return Paused(acc); }

fn resume(paused: Paused) -> Accumulated { return paused.acc; }
