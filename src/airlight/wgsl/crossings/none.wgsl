// Slabs that no surface cuts.

import package::faces::Face;
import package::front::Front;
import package::sample::{Part, Sample};
import package::walk::{Ends, Line};
import slot::integrate::Accumulated;

fn take_crossings(
  acc: ptr<function, Accumulated>, front: ptr<function, Front>, back: Sample, length: ptr<function, f32>,
  ends: Ends, line: Line, face: Face, part: Part, thinning: f32,
) -> bool {
  return false;
}
