// Extinction is that of the function alone.

import package::sample::Sample;

fn weight(front: Sample, back: Sample, length: f32) -> f32 { return 1.0; }
