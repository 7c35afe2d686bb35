// What lies behind the scene, put behind it: the whole is opaque then.

import generated::frame::frame;
import generated::pass::radiance;
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import slot::background::behind;
import slot::camera::eye_ray;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= frame.size_px.x || id.y >= frame.band_rows) { return; }
  let at = id.y * frame.size_px.x + id.x;
  let pixel = radiance[at];
  let ray = eye_ray(vec2f(id.xy) + vec2f(0.5, 0.5 + f32(frame.band_first_row)));
  if (all(ray.direction_world == vec3f(0.0))) { return; }
  radiance[at] = vec4f(pixel.rgb + (1.0 - pixel.a) * behind(ray), 1.0);
}
