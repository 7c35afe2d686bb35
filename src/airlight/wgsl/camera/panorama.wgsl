// Columns are degrees of azimuth, rows degrees of elevation.

import generated::panorama::params;
import generated::frame::frame;
import package::ray::Ray;

const FULL_TURN = 6.283185307;

fn eye_ray(p_px: vec2f) -> Ray {
  let angles = (vec2f(2.0, -2.0) * p_px / vec2f(frame.size_px) + vec2f(-1.0, 1.0)) * params.half_angles;
  let level = cos(angles.x) * params.forward + sin(angles.x) * params.right;
  return Ray(params.eye, normalize(cos(angles.y) * level + sin(angles.y) * params.up));
}

// Where all directions within an angle [rad] of one are seen: low and high on the image, whose edges are at -1 and 1. What goes on
// behind one edge comes back at the other, at the second `turn`.
fn seen_within(towards: vec3f, angle: f32, turn: u32) -> vec4f {
  let ahead = dot(towards, params.forward);
  let aside = dot(towards, params.right);
  let elevation = atan2(dot(towards, params.up), length(vec2f(ahead, aside)));
  let first = atan2(aside, ahead);
  let azimuth = select(first, first - select(-FULL_TURN, FULL_TURN, first > 0.0), turn == 1u);
  // Round a pole they are all round.
  let wide = asin(min(sin(min(angle, 0.25 * FULL_TURN)) / max(cos(elevation), 1e-6), 1.0));
  let reach = vec2f(select(0.5 * FULL_TURN, wide, abs(elevation) + angle < 0.25 * FULL_TURN), angle);
  let middle = vec2f(azimuth, elevation);
  return vec4f(middle - reach, middle + reach) / params.half_angles.xyxy;
}
