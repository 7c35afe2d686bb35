// Parallel rays from the plane through the eye.

import generated::orthographic::params;
import generated::frame::frame;
import package::ray::Ray;

fn eye_ray(p_px: vec2f) -> Ray {
  let aside = vec2f(2.0, -2.0) * p_px / vec2f(frame.size_px) + vec2f(-1.0, 1.0);
  return Ray(params.eye + aside.x * params.right + aside.y * params.up, params.forward);
}
