// Rays from one point.

import generated::perspective::params;
import generated::frame::frame;
import package::ray::Ray;

fn eye_ray(p_px: vec2f) -> Ray {
  let aside = vec2f(2.0, -2.0) * p_px / vec2f(frame.size_px) + vec2f(-1.0, 1.0);
  return Ray(params.eye, normalize(params.forward + aside.x * params.right + aside.y * params.up));
}

// Where a point is seen, for rasterisers: depth falls from 1 at the near plane towards 0.
fn clip_place(p_world: vec3f, near_world: f32, far_world: f32, p_px: vec2f) -> vec4f {
  let way = p_world - params.eye;
  let right = params.right / dot(params.right, params.right);
  let up = params.up / dot(params.up, params.up);
  return vec4f(dot(way, right), dot(way, up), near_world, dot(way, params.forward));
}
