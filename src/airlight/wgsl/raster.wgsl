// Corners of triangles on the part of the image that is drawn. What clips cut away of them: `slot::seen`.

import generated::frame::frame;
import generated::mesh::params;
import slot::camera::clip_place;

struct Corner { @builtin(position) place: vec4f, @location(0) @interpolate(flat) triangle: u32 }

// The first corner of each triangle is a vertex of its own, which has the triangle's number.
fn corner_of(p_mesh: vec3f, number: u32) -> Corner {
  let p_world = (params.world_from_mesh * vec4f(p_mesh, 1.0)).xyz;
  let place = clip_place(p_world, params.near_world, params.far_world, vec2f(frame.tile_origin_px) + 0.5);
  let down = vec2f(1.0, -1.0);
  let p_px = 0.5 * vec2f(frame.size_px) * (down * place.xy + place.w);
  let in_tile = (p_px - vec2f(frame.tile_origin_px) * place.w) / vec2f(frame.tile_size_px);
  return Corner(vec4f(down * (2.0 * in_tile - place.w), place.zw), number);
}
