// What a ray meets of a mesh: associated colour, opacity, distance.

import package::ray::INFINITE;
import package::sample::Result;

struct Cover { rgb: vec3f, alpha: f32, t_world: f32 }

const NO_COVER = Cover(vec3f(0.0), 0.0, INFINITE);
const COVER_NUMBERS = 5u;  // of a cover, one behind the other; distance 0 where there is none

// The near one in front of the far one; depth is where opacity passes one half.
fn result_over(near: Result, far: Result) -> Result {
  let through = 1.0 - near.alpha;
  let alpha = near.alpha + through * far.alpha;
  let passes = near.alpha < 0.5 && alpha >= 0.5;
  return Result(near.rgb + through * far.rgb, alpha, select(near.t_world, far.t_world, passes));
}
