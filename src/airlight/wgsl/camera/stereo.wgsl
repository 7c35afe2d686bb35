// Rays from the left eye in the left half of the image, from the right eye in the right half, or all from one of them.

import generated::stereo::params;
import generated::frame::frame;
import package::ray::Ray;

fn eye_ray(p_px: vec2f) -> Ray {
  let size_px = vec2f(frame.size_px);
  let second = in_second(p_px);
  let place = vec2f(p_px.x * params.views, p_px.y) / size_px - vec2f(second, 0.0);
  let aside = vec2f(2.0, -2.0) * place + vec2f(-1.0, 1.0);
  let to_eye = (params.first_side + 2.0 * second) * params.to_right_eye;
  let ahead = params.forward + aside.x * params.right + aside.y * params.up;
  return Ray(params.eye + to_eye, normalize(ahead - to_eye / params.convergence));
}

// Where a point is seen by the eye of a pixel, for rasterisers: depth falls from 1 at the near plane towards 0.
fn clip_place(p_world: vec3f, near_world: f32, far_world: f32, p_px: vec2f) -> vec4f {
  let second = in_second(p_px);
  let to_eye = (params.first_side + 2.0 * second) * params.to_right_eye;
  let way = p_world - params.eye - to_eye;
  let ahead = dot(way, params.forward);
  let on_screen = way + ahead / params.convergence * to_eye;
  let right = params.right / dot(params.right, params.right);
  let up = params.up / dot(params.up, params.up);
  let in_view = dot(on_screen, right) + ahead * (2.0 * second - params.views + 1.0);
  return vec4f(in_view / params.views, dot(on_screen, up), near_world, ahead);
}

fn in_second(p_px: vec2f) -> f32 { return f32(p_px.x * params.views >= f32(frame.size_px.x)); }
