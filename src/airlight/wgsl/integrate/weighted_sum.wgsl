// Light of the slabs added up. They come so thin that they attenuate nothing.

import generated::weighted_sum::params;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};

struct Accumulated { rgb: vec3f, met: u32 }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), 0u); }

// Even surfaces that are all but opaque have next to no opacity: what is left of attenuation is its first term.
fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  (*acc).rgb += lit_rgb * (1.0 + 0.5 * slab.alpha);
  (*acc).met = 1u;
  return false;
}

fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  return Accumulated(front.rgb + back.rgb, max(front.met, back.met));
}

fn finish(acc: Accumulated) -> Result {
  return Result(acc.rgb * params.gain, f32(acc.met), INFINITE);
}
