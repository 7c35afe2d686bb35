// Triangles in images that are no planes. What is drawn of each is the box of the image in which it is seen; pixels tell whether
// their rays meet it. Both triangles of an edge are told alike on which side of it a ray passes: there are no seams.

import generated::frame::frame;
import generated::mesh::params;
import package::corner::Corner;
import package::in_tile::in_tile;
import package::triangle::{Triangle, point_of, shares_of, triangle_of};
import slot::camera::{eye_ray, seen_within};

const MARGIN_PX = 0.0625;  // rasterisers round to 256ths of a pixel
const WIDEST = 1.5;        // [rad], of what is seen in a cap
const ALL_ROUND = 4.0;

// Depth falls from 1 at the eye towards 0.
struct Meeting { depth: f32, is_met: bool, is_front: bool }

// Six corners a triangle, three for each place at which the image may show it; of what they span the box is one half.
fn box_corner(number: u32) -> Corner {
  let seen = cap_of(triangle_of(number / 6u));
  let box = seen_within(seen.xyz, seen.w, (number / 3u) % 2u);
  let margin = 2.0 * MARGIN_PX / vec2f(frame.size_px);
  let low = box.xy - margin;
  let corner = number % 3u;
  let place = low + 2.0 * (box.zw + margin - low) * vec2f(f32(corner == 1u), f32(corner == 2u));
  return Corner(in_tile(vec4f(place, 0.5, 1.0)), number / 6u);
}

// The direction and the angle [rad] within which a triangle is seen.
fn cap_of(triangle: Triangle) -> vec4f {
  let from_eye = triangle.a - eye_ray(0.5 * vec2f(frame.size_px)).origin_world;
  let a = direction_of(from_eye);
  let b = direction_of(from_eye + triangle.b);
  let c = direction_of(from_eye + triangle.c);
  let middle = direction_of(a + b + c);
  let angle = 2.0 * asin(min(0.5 * max(length(a - middle), max(length(b - middle), length(c - middle))), 1.0));
  return vec4f(middle, select(ALL_ROUND, angle, angle < WIDEST));
}

fn direction_of(way: vec3f) -> vec3f { return way / max(length(way), 1e-30); }

fn meeting(at: Corner) -> Meeting {
  let ray = eye_ray(floor(at.place.xy) + 0.5 + vec2f(frame.tile_origin_px));
  let triangle = triangle_of(at.triangle);
  let a = triangle.a - ray.origin_world;
  let b = triangle.a + triangle.b - ray.origin_world;
  let c = triangle.a + triangle.c - ray.origin_world;
  let left = vec3<bool>(
    passes_left(ray.direction_world, a, b), passes_left(ray.direction_world, b, c), passes_left(ray.direction_world, c, a),
  );
  let t_world = dot(point_of(triangle, shares_of(triangle, ray)) - ray.origin_world, ray.direction_world);
  let is_met = (all(left) || !any(left)) && t_world > 0.0 && any(ray.direction_world != vec3f(0.0));
  return Meeting(params.near_world / (params.near_world + t_world), is_met, !left.x);
}

// Whether a ray passes the way from one point to another on its left; of the way back this is the other side, to the last digit.
fn passes_left(direction: vec3f, one: vec3f, other: vec3f) -> bool {
  let is_back = comes_before(other, one);
  let begin = select(one, other, is_back);
  let end = select(other, one, is_back);
  return (dot(direction, cross(begin, end - begin)) >= 0.0) != is_back;
}

fn comes_before(one: vec3f, other: vec3f) -> bool {
  return select(select(one.z < other.z, one.y < other.y, one.y != other.y), one.x < other.x, one.x != other.x);
}
