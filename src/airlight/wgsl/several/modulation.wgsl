// Layers thin their slabs themselves.

import package::sample::Sample;

fn weight(front: Sample, back: Sample, length: f32) -> f32 { return 1.0; }
