// Rays from the left eye in the left half of the image, from the right eye in the right half, or all from one of them.

import generated::stereo::params;
import generated::frame::frame;
import package::ray::Ray;

fn eye_ray(p_px: vec2f) -> Ray {
  let size_px = vec2f(frame.size_px);
  let second = f32(p_px.x * params.views >= size_px.x);
  let place = vec2f(p_px.x * params.views, p_px.y) / size_px - vec2f(second, 0.0);
  let aside = vec2f(2.0, -2.0) * place + vec2f(-1.0, 1.0);
  let to_eye = (params.first_side + 2.0 * second) * params.to_right_eye;
  let ahead = params.forward + aside.x * params.right + aside.y * params.up;
  return Ray(params.eye + to_eye, normalize(ahead - to_eye / params.convergence));
}
