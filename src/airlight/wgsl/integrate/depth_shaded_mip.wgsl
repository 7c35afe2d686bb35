// Maximum of values times a brightness that falls with distance from the eye.

import generated::depth_shaded_mip::params;
import generated::frame::frame;
import package::integrate::strongest::{Strongest, no_strongest, keep_stronger, show_strongest};
import package::sample::{Sample, Slab, Result};
import slot::values::scalar_of;

struct Accumulated { strongest: Strongest }

fn begin() -> Accumulated { return Accumulated(no_strongest()); }

fn strength_of(here: Sample) -> f32 { return (scalar_of(here.value) - params.first) * params.per_value; }

fn brightness_at(t_world: f32) -> f32 {
  return mix(1.0, params.darkest, saturate((t_world + frame.t_offset_world - params.near) * params.per_world));
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  let w_front = strength_of(front);
  let w_back = strength_of(back);
  let rise = w_back - w_front;
  let b_front = brightness_at(front.t_world);
  let fall = b_front - brightness_at(back.t_world);
  // Where strength rises and brightness falls, both straight, their product is a parabola with its top on the way.
  let top = select(1.0, 0.5 * (b_front / max(fall, 1e-30) - w_front / max(rise, 1e-30)), fall > 1e-12);
  let full = (1.0 - w_front) / max(rise, 1e-30);
  let share = select(0.0, saturate(min(top, full)), rise > 0.0 && w_back > 0.0);
  let brightness = b_front - share * fall;
  var strongest = (*acc).strongest;
  keep_stronger(&strongest, front, back, share, saturate(w_front + share * rise) * brightness, brightness);
  (*acc).strongest = strongest;
  return b_front - fall <= strongest.strength;
}

fn settled(acc: ptr<function, Accumulated>, bound: f32, t_world: f32) -> bool {
  let most = saturate((bound - params.first) * params.per_value) * brightness_at(t_world);
  return (*acc).strongest.met > 0u && most <= (*acc).strongest.strength;
}

fn finish(acc: Accumulated) -> Result { return show_strongest(acc.strongest); }
