// Sums for the log-average luminance over covered pixels, weighted by their coverage. The host adds the sums up.

import generated::pass::{radiance, sums};
import generated::frame::frame;
import generated::sizes::LUMINANCE_SUMS;
import package::colour::luminance;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
  var sum = vec2f(0.0);
  for (var i = id.x; i < frame.size_px.x * frame.band_rows; i += LUMINANCE_SUMS) {
    let pixel = radiance[i];
    if (pixel.a > 0.0) { sum += pixel.a * vec2f(log(1e-6 + luminance(pixel.rgb) / pixel.a), 1.0); }
  }
  sums[id.x] = sum;
}
