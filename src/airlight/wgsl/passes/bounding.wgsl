// Distances at which rays meet faces of the blocks that hold something. Which faces are seen, the nearest or the farthest, is a
// matter of the test of depths. A ray that meets a face from inside first begins within a block.

import generated::frame::frame;
import generated::group::params as group;
import package::on_tile::on_tile;
import slot::camera::eye_ray;

struct Corner { @builtin(position) place: vec4f, @location(0) p_world: vec3f }

@vertex
fn at_corner(@location(0) p_world: vec3f) -> Corner {
  return Corner(on_tile(p_world, group.near_world, group.far_world), p_world);
}

@fragment
fn first_face(at: Corner, @builtin(front_facing) is_front: bool) -> @location(0) f32 { return select(0.0, distance_of(at), is_front); }

@fragment
fn last_face(at: Corner) -> @location(0) f32 { return distance_of(at); }

fn distance_of(at: Corner) -> f32 {
  let ray = eye_ray(at.place.xy + vec2f(frame.tile_origin_px));
  return dot(at.p_world - ray.origin_world, ray.direction_world);
}
