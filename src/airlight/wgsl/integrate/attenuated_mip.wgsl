// Maximum of the values that reach the eye, each attenuated by those before it.

import generated::attenuated_mip::params;
import package::integrate::strongest::{Strongest, no_strongest, keep_stronger, show_strongest};
import package::sample::{Sample, Slab, Result};
import slot::values::scalar_of;

struct Accumulated { strongest: Strongest, depth: f32 }

fn begin() -> Accumulated { return Accumulated(no_strongest(), 0.0); }

fn strength_of(here: Sample) -> f32 { return (scalar_of(here.value) - params.first) * params.per_value; }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  let w_front = strength_of(front);
  let w_back = strength_of(back);
  let depth = params.attenuation * length;
  // Strength w arrives as w exp(-D): it grows on the way as long as dw exceeds w^2 times the depth of the slab.
  let rise = w_back - w_front;
  let top = min(sqrt(max(rise, 0.0) / max(depth, 1e-30)), 1.0);
  let share = select(0.0, saturate((top - w_front) / max(rise, 1e-30)), rise > 0.0 && w_back > 0.0);
  let through = exp(-((*acc).depth + depth * passed(w_front, w_front + share * rise) * share));
  var strongest = (*acc).strongest;
  keep_stronger(&strongest, front, back, share, saturate(w_front + share * rise) * through, through);
  (*acc).strongest = strongest;
  (*acc).depth += depth * passed(w_front, w_back);
  return exp(-(*acc).depth) <= strongest.strength;
}

// Mean strength, at least 0 and at most 1, along a straight line between two.
fn passed(a: f32, b: f32) -> f32 {
  let width = b - a;
  if (abs(width) < 1e-3) { return saturate(0.5 * (a + b)); }
  return (primitive(b) - primitive(a)) / width;
}

fn primitive(w: f32) -> f32 {
  let held = saturate(w);
  return 0.5 * held * held + max(w - 1.0, 0.0);
}

// Up to the function's first value nothing is shown nor attenuates.
fn settled(acc: ptr<function, Accumulated>, bound: f32, t_world: f32) -> bool {
  return (*acc).strongest.met > 0u && bound <= params.first;
}

fn finish(acc: Accumulated) -> Result { return show_strongest(acc.strongest); }
