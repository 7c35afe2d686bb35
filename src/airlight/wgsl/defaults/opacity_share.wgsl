// Within a slab opacity grows as in a homogeneous medium.

import package::sample::Sample;

fn opacity_share(front: Sample, back: Sample, length: f32, alpha: f32, wanted: f32) -> f32 {
  return saturate(log(1.0 - wanted) / log(max(1.0 - alpha, 1e-30)));
}
