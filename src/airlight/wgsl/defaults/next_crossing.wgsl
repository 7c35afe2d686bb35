// No crossing within the slab.

import package::sample::Sample;

fn next_crossing(front: Sample, back: Sample, from: f32) -> f32 { return 2.0; }
