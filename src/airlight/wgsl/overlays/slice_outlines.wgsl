// Outlines of slices: contour lines, on the faces of the first layer's domain, of the numbers that slices have.

import generated::frame::frame;
import generated::pass::{backdrop, depth, domains, radiance, slices};
import generated::slice_outlines::params;
import package::overlays::under::put_under;
import package::picture::place;
import package::ray::Ray;
import slot::camera::eye_ray;

// A face of the unit cube: the plane in which one coordinate is 0 or 1, in the world.
struct Face { p_world: vec3f, normal: vec3f }

fn face_of(domain: mat4x4f, axis: u32, side: f32) -> Face {
  let normal = cross(domain[(axis + 1u) % 3u].xyz, domain[(axis + 2u) % 3u].xyz);
  return Face(domain[3].xyz + side * domain[axis].xyz, normal);
}

fn passes_at(ray: Ray, face: Face) -> f32 {
  return dot(face.p_world - ray.origin_world, face.normal) / dot(ray.direction_world, face.normal);
}

// Slices are planes, or shells round the eye if their normal is zero; some of those may lie before the rays begin.
fn number_at(ray: Ray, t_world: f32) -> f32 {
  let normal = slices[0].xyz;
  let along = dot(normal, ray.origin_world + t_world * ray.direction_world) - slices[0].w;
  let number = select(along, t_world, all(normal == vec3f(0.0))) / slices[1].x;
  return (number + slices[1].y % params.every) / params.every;
}

// How much of a pixel a line covers where its ray passes a face.
fn cover_of(ray: Ray, right: Ray, down: Ray, face: Face, t_world: f32) -> f32 {
  let number = number_at(ray, t_world);
  let to_right = number_at(right, passes_at(right, face)) - number;
  let to_below = number_at(down, passes_at(down, face)) - number;
  let per_px = max(length(vec2f(to_right, to_below)), 1e-9);
  let line = saturate(0.5 * params.width_px + 0.5 - abs(number - round(number)) / per_px);
  // Where lines are as close as pixels they become an even grey.
  return mix(line, saturate(params.width_px * per_px), smoothstep(0.5, 1.0, per_px));
}

fn pixel(p_px: vec2i) -> vec4f {
  let at = place(p_px);
  let centre = vec2f(p_px) + 0.5;
  let ray = eye_ray(centre);
  let right = eye_ray(centre + vec2f(1.0, 0.0));
  let down = eye_ray(centre + vec2f(0.0, 1.0));
  let domain = domains[0];
  var first = Face();
  var last = Face();
  var enter = -3.4e38;
  var leave = 3.4e38;
  for (var axis = 0u; axis < 3u; axis++) {
    let low = face_of(domain, axis, 0.0);
    let high = face_of(domain, axis, 1.0);
    let t = vec2f(passes_at(ray, low), passes_at(ray, high));
    let is_up = t.x < t.y;
    if (min(t.x, t.y) > enter) {
      enter = min(t.x, t.y);
      first = Face(select(high.p_world, low.p_world, is_up), low.normal);
    }
    if (max(t.x, t.y) < leave) {
      leave = max(t.x, t.y);
      last = Face(select(low.p_world, high.p_world, is_up), low.normal);
    }
  }
  let is_seen = f32(leave > max(enter, 0.0) && any(ray.direction_world != vec3f(0.0))) * params.opacity;
  let before = select(0.0, cover_of(ray, right, down, first, enter), enter > 0.0 && enter < depth[at].x - frame.t_offset_world) * is_seen;
  let behind = cover_of(ray, right, down, last, leave) * is_seen;
  let under = put_under(radiance[at], backdrop[at], params.color, behind);
  return mix(under, vec4f(params.color, 1.0), before);
}
