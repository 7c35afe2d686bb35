// Edges of the domains of all layers: what is seen of them lies wholly before the volume or wholly behind it.

import generated::bounding_box::params;
import generated::frame::frame;
import generated::pass::{backdrop, depth, domains, radiance};
import package::overlays::under::put_under;
import package::picture::place;
import package::ray::Ray;
import slot::camera::eye_ray;

// Where a ray is nearest to an edge: its distance from the eye, and how far the edge lies to the side.
fn nearest(ray: Ray, corner: vec3f, edge: vec3f) -> vec2f {
  let from_corner = ray.origin_world - corner;
  let along = dot(ray.direction_world, edge);
  let ahead = dot(ray.direction_world, from_corner);
  // Zero for an edge that is seen from its end, of which any place will do.
  let apart = max(dot(edge, edge) - along * along, 1e-6 * dot(edge, edge));
  let share = saturate((dot(edge, from_corner) - along * ahead) / apart);
  let t_world = share * along - ahead;
  return vec2f(t_world, length(from_corner + t_world * ray.direction_world - share * edge));
}

// How far two rays are apart at a distance from the eye.
fn apart_at(one: Ray, other: Ray, t_world: f32) -> f32 {
  return length(one.origin_world - other.origin_world + t_world * (one.direction_world - other.direction_world));
}

fn pixel(p_px: vec2i) -> vec4f {
  let at = place(p_px);
  let ray = eye_ray(vec2f(p_px) + 0.5);
  // The next pixel to one side may be that of another eye.
  let left = eye_ray(vec2f(p_px) + vec2f(-0.5, 0.5));
  let right = eye_ray(vec2f(p_px) + vec2f(1.5, 0.5));
  var before = 0.0;
  var behind = 0.0;
  for (var n = 0u; n < arrayLength(&domains); n++) {
    let domain = domains[n];
    let t_middle = dot((domain * vec4f(0.5, 0.5, 0.5, 1.0)).xyz - ray.origin_world, ray.direction_world);
    for (var i = 0u; i < 12u; i++) {
      let axis = i / 4u;
      let sides = vec2f(f32(i & 1u), f32(i / 2u & 1u));
      let corner = select(select(vec3f(sides, 0.0), vec3f(sides.x, 0.0, sides.y), axis == 1u), vec3f(0.0, sides), axis == 0u);
      let found = nearest(ray, (domain * vec4f(corner, 1.0)).xyz, domain[axis].xyz);
      let pixel_world = min(apart_at(ray, left, found.x), apart_at(ray, right, found.x));
      let cover = saturate(0.5 * params.width_px + 0.5 - found.y / pixel_world) * step(0.0, found.x);
      let is_before = found.x < min(t_middle, depth[at].x - frame.t_offset_world);
      before = max(before, select(0.0, cover, is_before));
      behind = max(behind, select(cover, 0.0, is_before));
    }
  }
  let is_seen = f32(any(ray.direction_world != vec3f(0.0))) * params.opacity;
  let under = put_under(radiance[at], backdrop[at], params.color, behind * is_seen);
  return mix(under, vec4f(params.color, 1.0), before * is_seen);
}
