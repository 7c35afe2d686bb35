// No surface within the slab.

import package::sample::{Sample, Sheet};

fn next_crossing(front: Sample, back: Sample, passed: u32) -> Sheet {
  return Sheet(2.0, 0.0, 0u, false, vec3f(0.0), 0.0);
}
