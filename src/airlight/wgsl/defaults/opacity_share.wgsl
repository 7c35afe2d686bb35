// Within a slab opacity grows as in a homogeneous medium.

import generated::sizes::Values;

fn opacity_share(front: Values, back: Values, length: f32, alpha: f32, wanted: f32) -> f32 {
  return saturate(log(1.0 - wanted) / log(max(1.0 - alpha, 1e-30)));
}
