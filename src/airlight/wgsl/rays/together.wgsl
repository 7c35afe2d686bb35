// A ray through all that there is, slab by slab.

import package::covered::covered;
import package::met::Met;
import package::ray::INFINITE;
import package::sample::Result;
import package::slabs::march_part;
import package::walk::Line;
import slot::integrate::{begin, finish};

fn march(line: Line, at: u32, samples: ptr<function, f32>, met: ptr<function, Met>) -> Result {
  var acc = begin();
  var covers_taken = 1u;
  march_part(line, line.enter, INFINITE, at, &acc, &covers_taken, samples, met);
  return covered(finish(acc), at, covers_taken);
}
