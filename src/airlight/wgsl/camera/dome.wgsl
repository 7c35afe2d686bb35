// A disk in which the way from the middle is the angle from the view's axis; none beside it.

import generated::dome::params;
import generated::frame::frame;
import package::ray::Ray;

fn eye_ray(p_px: vec2f) -> Ray {
  let angles = (vec2f(2.0, -2.0) * p_px / vec2f(frame.size_px) + vec2f(-1.0, 1.0)) * params.half_angles;
  let from_axis = length(angles);
  if (from_axis > min(params.half_angles.x, params.half_angles.y)) { return Ray(params.eye, vec3f(0.0)); }
  let across = select(sin(from_axis) / from_axis, 1.0, from_axis < 1e-4);
  let direction = cos(from_axis) * params.forward + across * (angles.x * params.right + angles.y * params.up);
  return Ray(params.eye, normalize(direction));
}
