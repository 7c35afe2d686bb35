// Light of the slabs added up. They come so thin that they attenuate nothing.

import generated::weighted_sum::params;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};

struct Accumulated { rgb: vec3f, met: bool }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), false); }

// Even surfaces that are all but opaque have next to no opacity: what is left of attenuation is its first term.
fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  (*acc).rgb += lit_rgb * (1.0 + 0.5 * slab.alpha);
  (*acc).met = true;
  return false;
}

fn finish(acc: Accumulated) -> Result {
  return Result(acc.rgb * params.gain, select(0.0, 1.0, acc.met), INFINITE);
}
