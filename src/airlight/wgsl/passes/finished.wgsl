// Rays that were drawn part by part, finished.

import generated::frame::frame;
import generated::pass::{depth, radiance, unfinished};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::covered::covered;
import package::unfinished::Unfinished;
import package::walk::Fetched;  // of several layers a sample is what their walk fetches
import slot::integrate::{begin, finish, resume};
import slot::tone::tone;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= frame.tile_size_px)) { return; }
  let pixel = frame.tile_origin_px + id.xy;
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let ray = unfinished[id.y * frame.tile_size_px.x + id.x];
  var acc = begin();
  if (ray.covers_taken > 0u) { acc = resume(ray.paused); }
  let result = covered(finish(acc), at, max(ray.covers_taken, 1u));
  radiance[at] = vec4f(tone(result.rgb, vec2f(pixel) + 0.5), result.alpha);
  depth[at] = vec2f(result.t_world + frame.t_offset_world, ray.samples);
}
