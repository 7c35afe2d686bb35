// Light on surfaces that a march has found: see `hits/kept.wgsl`.

import generated::frame::frame;
import generated::pass::{radiance, depth, hits};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::relit::relit;
import slot::camera::eye_ray;
import slot::tone::tone;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= frame.size_px.x || id.y >= frame.band_rows) { return; }
  let at = id.y * frame.size_px.x + id.x;
  let p_px = vec2f(id.xy) + vec2f(0.5, 0.5 + f32(frame.band_first_row));
  let place = hits[2u * at + 1u];
  let is_hit = place.y > 0.0;
  let lit = relit(u32(place.z), hits[2u * at], place.y, select(0.0, place.x, is_hit), eye_ray(p_px));
  radiance[at] = select(vec4f(0.0), vec4f(tone(lit, p_px), 1.0), is_hit);
  depth[at] = vec2f(place.x + frame.t_offset_world, 0.0);
}
