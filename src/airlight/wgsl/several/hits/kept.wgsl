// What was found at surfaces is kept of the layer whose surface it is; where no surfaces are looked for, of the most opaque one.

import generated::sizes::{CUTS_LAYERS, SURFACES_ONLY};
import next::several::gradients::{densest, gradient_of_layer};
import next::several::layer::parts_at;
import package::kept_hit::{side_of, write_hit};
import package::met::Met;
import package::sample::Result;
import package::walk::Line;

fn keep_hit(pixel: u32, line: Line, shown: Result, met: Met) {
  let side = side_of(met, shown.t_world);
  let t_world = select(0.0, shown.t_world, side > 0.0);
  var number = met.layer;
  if (!SURFACES_ONLY) {
    var lines = line.lines;
    if (CUTS_LAYERS) { lines = parts_at(lines, t_world); }
    number = densest(lines, t_world).number;
  }
  write_hit(pixel, gradient_of_layer(line.lines, number, met.clip, t_world), met.value, shown.t_world, side, number);
}
