// Sums for the log-average luminance over covered pixels, weighted by their coverage. The host adds the sums up.

import generated::pass::{radiance, sums};
import generated::frame::frame;
import generated::sizes::LUMINANCE_SUMS;
import package::colour::luminance;

const GROUP: u32 = 32u;

// A group goes through pixels that lie in a row: strides through all of them take twice as long.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
  let pixels = frame.size_px.x * frame.band_rows;
  let each = (pixels + LUMINANCE_SUMS / GROUP - 1u) / (LUMINANCE_SUMS / GROUP);
  let first = group.x * each;
  var sum = vec2f(0.0);
  for (var i = first + local.x; i < min(first + each, pixels); i += GROUP) {
    let pixel = radiance[i];
    if (pixel.a > 0.0) { sum += pixel.a * vec2f(log(1e-6 + luminance(pixel.rgb) / pixel.a), 1.0); }
  }
  sums[group.x * GROUP + local.x] = sum;
}
