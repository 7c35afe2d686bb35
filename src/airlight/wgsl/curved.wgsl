// Values put right for the field's curvature along a ray: a sample is moved away from the straight line between its neighbours
// by a sixth of its distance. Straight lines between such samples have the mean of the curve, where it is a parabola.

import generated::sizes::{HAS_EMPTY, Values};
import package::sample::Sample;
import slot::values::{has_gap, mix_values};

fn curved_value(before: Sample, here: Sample, after: Sample) -> Values {
  if (HAS_EMPTY && (has_gap(before.value) || has_gap(here.value) || has_gap(after.value))) { return here.value; }
  let share = (here.t_world - before.t_world) / max(after.t_world - before.t_world, 1e-30);
  let straight = mix_values(before.value, after.value, share);
  return mix_values(straight, here.value, 7.0 / 6.0);
}
