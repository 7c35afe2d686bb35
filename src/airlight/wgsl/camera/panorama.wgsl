// Columns are degrees of azimuth, rows degrees of elevation.

import generated::panorama::params;
import generated::frame::frame;
import package::ray::Ray;

fn eye_ray(p_px: vec2f) -> Ray {
  let angles = (vec2f(2.0, -2.0) * p_px / vec2f(frame.size_px) + vec2f(-1.0, 1.0)) * params.half_angles;
  let level = cos(angles.x) * params.forward + sin(angles.x) * params.right;
  return Ray(params.eye, normalize(cos(angles.y) * level + sin(angles.y) * params.up));
}
