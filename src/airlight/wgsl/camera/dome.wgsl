// A disk in which the way from the middle is the angle from the view's axis; none beside it.

import generated::dome::params;
import generated::frame::frame;
import package::ray::Ray;

const MOST_BEHIND = 3.1;   // [rad]
const ALL_OF_IT = 100.0;   // more than any image shows
const BESIDE_IT = 9.0;  // beside the image

fn eye_ray(p_px: vec2f) -> Ray {
  let angles = (vec2f(2.0, -2.0) * p_px / vec2f(frame.size_px) + vec2f(-1.0, 1.0)) * params.half_angles;
  let from_axis = length(angles);
  if (from_axis > min(params.half_angles.x, params.half_angles.y)) { return Ray(params.eye, vec3f(0.0)); }
  let across = select(sin(from_axis) / from_axis, 1.0, from_axis < 1e-4);
  let direction = cos(from_axis) * params.forward + across * (angles.x * params.right + angles.y * params.up);
  return Ray(params.eye, normalize(direction));
}

// Where all directions within an angle [rad] of one are seen: low and high on the image, whose edges are at -1 and 1.
fn seen_within(towards: vec3f, angle: f32, turn: u32) -> vec4f {
  let across = vec2f(dot(towards, params.right), dot(towards, params.up));
  let from_axis = atan2(length(across), dot(towards, params.forward));
  // Ways round the axis are stretched, without end towards what lies behind.
  let farthest = from_axis + angle;
  let reach = select(ALL_OF_IT, angle * farthest / max(sin(min(farthest, MOST_BEHIND)), 1e-6), farthest < MOST_BEHIND);
  let middle = from_axis * across / max(length(across), 1e-30);
  let found = vec4f(middle - reach, middle + reach) / params.half_angles.xyxy;
  return select(found, vec4f(BESIDE_IT), turn == 1u);
}
