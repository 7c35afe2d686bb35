// What was found at surfaces is kept for light that comes later.

import package::faces::face_gradient;
import package::kept_hit::{side_of, write_hit};
import package::met::Met;
import package::sample::Result;
import package::walk::Line;
import slot::field::locate;
import slot::gradient::field_gradient;

fn keep_hit(pixel: u32, line: Line, shown: Result, met: Met) {
  let side = side_of(met, shown.t_world);
  let t_world = select(0.0, shown.t_world, side > 0.0);
  var gradient = field_gradient(locate(line.index.origin + t_world * line.index.direction));
  if (met.clip > 0u) { gradient = face_gradient(met.clip, line.ray.origin_world + t_world * line.ray.direction_world); }
  write_hit(pixel, gradient, met.value, shown.t_world, side, 0u);
}
