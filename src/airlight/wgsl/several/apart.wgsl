// What each layer shows of a ray by itself, in no order: light adds up, as that of pictures thrown on one screen.

import next::several::apart::show_all as rest_show_all;
import package::met::Met;
import package::ray::INFINITE;
import package::sample::Result;
import package::several::apart_end::Shown;
import package::several::layer::Lines;
import package::slabs::march_part;
import slot::integrate::{begin, finish};

fn show_all(lines: Lines, at: u32) -> Shown {
  var acc = begin();
  var covers_taken = 1u;
  var samples = 0.0;
  var met = Met(0.0, 0.0, 0u, 0u);
  march_part(lines.own, lines.own.enter, INFINITE, at, &acc, &covers_taken, &samples, &met);
  return beside(finish(acc), samples, rest_show_all(lines.rest, at));
}

// Depth is that of the layer from which most light comes; of equal ones the nearest.
fn beside(own: Result, samples: f32, rest: Shown) -> Shown {
  let brightness = select(-1.0, dot(own.rgb, vec3f(1.0)), own.t_world < INFINITE);
  let is_nearer = brightness == rest.brightest && own.t_world < rest.t_world;
  let sign = select(1.0, -1.0, min(samples, rest.samples) < 0.0);
  return Shown(
    own.rgb + rest.rgb,
    1.0 - (1.0 - own.alpha) * (1.0 - rest.alpha),
    select(rest.t_world, own.t_world, brightness > rest.brightest || is_nearer),
    max(brightness, rest.brightest),
    sign * (abs(samples) + abs(rest.samples)),
  );
}
