// A ray through each of several layers by itself.

import next::several::apart::show_all;
import package::covered::covered;
import package::met::Met;
import package::sample::Result;
import package::walk::Line;

fn march(line: Line, at: u32, samples: ptr<function, f32>, met: ptr<function, Met>) -> Result {
  let shown = show_all(line.lines, at);
  *samples = shown.samples;
  return covered(Result(shown.rgb, shown.alpha, shown.t_world), at, 1u);
}
