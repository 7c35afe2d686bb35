// The ray march: one ray a pixel, from the eye to where it ends.

import generated::frame::frame;
import generated::pass::{radiance, depth};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::met::Met;
import package::places::place_in_tile;
import package::walk::line_of;
import slot::camera::eye_ray;
import slot::hits::keep_hit;
import slot::pixels::pixel_at;
import slot::rays::march;
import slot::reach::bounded;
import slot::tone::tone;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
  let place = place_in_tile(group.xy, thread);
  if (any(place >= frame.tile_size_px)) { return; }
  let pixel = pixel_at(place);
  let p_px = vec2f(pixel) + 0.5;
  var samples = 0.0;
  var met = Met(0.0, 0.0, 0u, 0u);
  let line = bounded(line_of(eye_ray(p_px), pixel), pixel);
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let result = march(line, at, &samples, &met);
  radiance[at] = vec4f(tone(result.rgb, p_px), result.alpha);
  depth[at] = vec2f(result.t_world + frame.t_offset_world, samples);
  keep_hit(at, line, result, met);
}
