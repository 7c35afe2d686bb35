// What another light makes is added; opacity and depth are those of the first. Samples are negative where one of both ended early.

import generated::frame::frame;
import generated::pass::{added_depth, added_radiance, depth, radiance};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= vec2u(frame.size_px.x, frame.band_rows))) { return; }
  let at = id.y * frame.size_px.x + id.x;
  radiance[at] = vec4f(radiance[at].rgb + added_radiance[at].rgb, radiance[at].a);
  let samples = vec2f(depth[at].y, added_depth[at].y);
  depth[at].y = select(samples.x + samples.y, -abs(samples.x) - abs(samples.y), any(samples < vec2f(0.0)));
}
