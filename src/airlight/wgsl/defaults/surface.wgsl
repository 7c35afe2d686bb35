// No surface: the ray goes on.

import package::sample::Sample;

fn surface(front: Sample, back: Sample) -> f32 { return 2.0; }
