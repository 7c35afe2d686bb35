// The strongest sample along a ray, shown in the function's colour, as bright as it arrives at the eye.

import package::ray::INFINITE;
import package::sample::{Sample, Result};
import slot::transfer::medium;
import slot::values::mix_values;

struct Strongest { here: Sample, strength: f32, brightness: f32, met: u32 }

fn no_strongest() -> Strongest {
  var none: Strongest;
  return none;
}

// A share of the way from the front to the back of a slab, of this strength at the eye.
fn keep_stronger(
  kept: ptr<function, Strongest>, front: Sample, back: Sample, share: f32, strength: f32, brightness: f32,
) {
  if ((*kept).met > 0u && strength <= (*kept).strength) { return; }
  let here = Sample(
    mix_values(front.value, back.value, share),
    vec3f(0.0),
    mix(front.p_index, back.p_index, share),
    mix(front.p_world, back.p_world, share),
    mix(front.t_world, back.t_world, share),
  );
  (*kept) = Strongest(here, strength, brightness, 1u);
}

fn show_strongest(kept: Strongest) -> Result {
  if (kept.met == 0u) { return Result(vec3f(0.0), 0.0, INFINITE); }
  return Result(medium(kept.here).rgb * kept.brightness, 1.0, kept.here.t_world);
}
