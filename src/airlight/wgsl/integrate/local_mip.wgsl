// The first local maximum that reaches a threshold, else the greatest value.

import generated::local_mip::params;
import package::integrate::extreme::{Extreme, exceeds, no_extreme, keep, show};
import package::sample::{Sample, Slab, Result};
import slot::values::scalar_of;

struct Accumulated { extreme: Extreme }

fn begin() -> Accumulated { return Accumulated(no_extreme()); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  var extreme = (*acc).extreme;
  keep(&extreme, front, scalar_of(front.value) > scalar_of(extreme.here.value));
  let greatest = scalar_of(extreme.here.value);
  let falls = greatest - params.drop;
  // The front of a slab may fall, too: behind a gap.
  if (greatest >= params.threshold && (scalar_of(front.value) < falls || scalar_of(back.value) < falls)) {
    (*acc).extreme = extreme;
    return true;
  }
  keep(&extreme, back, scalar_of(back.value) > greatest);
  (*acc).extreme = extreme;
  return false;
}

// Once the threshold is reached it matters where values fall.
fn settled(acc: ptr<function, Accumulated>, bound: f32, t_world: f32) -> bool {
  return exceeds((*acc).extreme, bound) && scalar_of((*acc).extreme.here.value) < params.threshold;
}

fn finish(acc: Accumulated) -> Result { return show(acc.extreme); }
