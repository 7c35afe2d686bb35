// The ray march: one ray a pixel, from the eye to where it ends.

import generated::frame::frame;
import generated::pass::{radiance, depth};
import generated::sizes::SURFACES_ONLY;
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::faces::face_gradient;
import package::met::Met;
import package::pieces::covered;
import package::places::place_in_tile;
import package::ray::INFINITE;
import package::sample::Result;
import package::slabs::march_part;
import package::walk::{Line, line_of};
import slot::camera::eye_ray;
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::hits::{KEEPS_HITS, keep_hit};
import slot::integrate::{begin, finish};
import slot::pixels::pixel_at;
import slot::reach::bounded;
import slot::tone::tone;

const HALF_OPAQUE = 4.0;  // the side of what is kept where no surfaces are looked for

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
  let place = place_in_tile(group.xy, thread);
  if (any(place >= frame.tile_size_px)) { return; }
  let pixel = pixel_at(place);
  let p_px = vec2f(pixel) + 0.5;
  var samples = 0.0;
  var met = Met(0.0, 0.0, 0u);
  let line = bounded(line_of(eye_ray(p_px), pixel), pixel);
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let result = march(line, at, &samples, &met);
  radiance[at] = vec4f(tone(result.rgb, p_px), result.alpha);
  depth[at] = vec2f(result.t_world + frame.t_offset_world, samples);
  if (KEEPS_HITS) {
    if (!SURFACES_ONLY && result.t_world < INFINITE) { met.side = HALF_OPAQUE; }
    let t_world = select(0.0, result.t_world, met.side > 0.0);
    var gradient = field_gradient(locate(line.index.origin + t_world * line.index.direction));
    if (met.clip > 0u) { gradient = face_gradient(met.clip, line.ray.origin_world + t_world * line.ray.direction_world); }
    keep_hit(at, vec4f(gradient, met.value) * f32(met.side > 0.0), vec4f(result.t_world, met.side, 0.0, 0.0));
  }
}

fn march(line: Line, at: u32, samples: ptr<function, f32>, met: ptr<function, Met>) -> Result {
  var acc = begin();
  var covers_taken = 1u;
  march_part(line, line.enter, INFINITE, at, &acc, &covers_taken, samples, met);
  return covered(finish(acc), at, covers_taken);
}
