// The tone stage over a finished image, for those that look at the whole of it first.

import generated::frame::frame;
import generated::pass::radiance;
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import slot::tone::tone;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= frame.size_px.x || id.y >= frame.band_rows) { return; }
  let at = id.y * frame.size_px.x + id.x;
  let pixel = radiance[at];
  radiance[at] = vec4f(tone(pixel.rgb, vec2f(id.xy) + vec2f(0.5, 0.5 + f32(frame.band_first_row))), pixel.a);
}
