// Optical depth added up, shown as it is or as what it lets through. Slabs come so thin that opacity is depth.

import generated::xray::{params, SHOW};
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};

struct Accumulated { depth: f32, met: u32 }

fn begin() -> Accumulated { return Accumulated(0.0, 0u); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  (*acc).depth += slab.alpha * (1.0 + 0.5 * slab.alpha) / params.thinned;
  (*acc).met = 1u;
  return false;
}

fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  return Accumulated(front.depth + back.depth, max(front.met, back.met));
}

fn finish(acc: Accumulated) -> Result {
  if (acc.met == 0u) { return Result(vec3f(0.0), 0.0, INFINITE); }
  let measured = select(exp(-acc.depth), acc.depth, SHOW == 0u);
  return Result(vec3f(max((measured - params.black) * params.gain, 0.0)), 1.0, INFINITE);
}
