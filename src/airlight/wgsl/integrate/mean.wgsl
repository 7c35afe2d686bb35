// The mean value along the way through the domain, shown in the function's colour.

import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::transfer::medium;

struct Accumulated { integral: f32, length: f32 }

fn begin() -> Accumulated { return Accumulated(0.0, 0.0); }

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  (*acc).integral += 0.5 * (front.value + back.value) * length;
  (*acc).length += length;
  return false;
}

fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  return Accumulated(front.integral + back.integral, front.length + back.length);
}

fn finish(acc: Accumulated) -> Result {
  if (acc.length <= 0.0) { return Result(vec3f(0.0), 0.0, INFINITE); }
  var mean: Sample;
  mean.value = acc.integral / acc.length;
  return Result(medium(mean).rgb, 1.0, INFINITE);
}
