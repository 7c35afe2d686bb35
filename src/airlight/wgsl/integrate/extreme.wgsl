// An extreme value along a ray, shown in the function's colour.

import package::ray::INFINITE;
import package::sample::{Sample, Result};
import slot::transfer::medium;
import slot::values::scalar_of;

struct Extreme { here: Sample, met: u32 }

fn no_extreme() -> Extreme {
  var none: Extreme;
  return none;
}

fn keep(extreme: ptr<function, Extreme>, other: Sample, better: bool) {
  if ((*extreme).met == 0u || better) { (*extreme) = Extreme(other, 1u); }
}

// Whether something has been found that no value up to a bound exceeds, or that none from a bound on falls short of.
fn exceeds(extreme: Extreme, bound: f32) -> bool { return extreme.met > 0u && bound <= scalar_of(extreme.here.value); }

fn falls_short(extreme: Extreme, bound: f32) -> bool { return extreme.met > 0u && bound >= scalar_of(extreme.here.value); }

fn show(extreme: Extreme) -> Result {
  if (extreme.met == 0u) { return Result(vec3f(0.0), 0.0, INFINITE); }
  return Result(medium(extreme.here).rgb, 1.0, extreme.here.t_world);
}
