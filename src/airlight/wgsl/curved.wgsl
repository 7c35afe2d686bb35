// Values put right for the field's curvature along a ray: a sample is moved away from the straight line between its neighbours
// by a sixth of its distance. Straight lines between such samples have the mean of the curve, where it is a parabola.

import generated::sizes::{HAS_EMPTY, Values};
import package::walk::Fetched;
import slot::transfer::held;
import slot::values::{mix_values, where_there};

fn curved_value(before: Fetched, here: Fetched, after: Fetched) -> Values {
  let share = (here.t_world - before.t_world) / max(after.t_world - before.t_world, 1e-30);
  let straight = mix_values(before.value, after.value, share);
  let moved = held(here.value, mix_values(straight, here.value, 7.0 / 6.0));
  if (!HAS_EMPTY) { return moved; }
  // What is not there in one of the three stays as it is.
  return where_there(before.value, where_there(here.value, where_there(after.value, moved, here.value), here.value), here.value);
}
