// Within a slab opacity grows as in a homogeneous medium.

import generated::sizes::CROSSES_EVEN;
import package::sample::Sample;
import slot::transfer::medium;

const NEARLY_OPAQUE = 0.999999;
const DEEP = 13.8;  // optical depth of that opacity

fn opacity_share(front: Sample, back: Sample, length: f32, alpha: f32, wanted: f32) -> f32 {
  var depth = -log(max(1.0 - alpha, 1e-30));
  if (CROSSES_EVEN) {
    // What is all but opaque does not tell how dense it is: a slab that long lies in one medium.
    let known = 0.5 * length * (medium(front).extinction + medium(back).extinction);
    depth = select(depth, known, alpha > NEARLY_OPAQUE && known > DEEP);
  }
  return saturate(-log(1.0 - wanted) / depth);
}
