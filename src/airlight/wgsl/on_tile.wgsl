// Where a point lies on the part of the image that is drawn, for rasterisers.

import generated::frame::frame;
import package::in_tile::in_tile;
import slot::camera::clip_place;

fn on_tile(p_world: vec3f, near_world: f32, far_world: f32) -> vec4f {
  return in_tile(clip_place(p_world, near_world, far_world, vec2f(frame.tile_origin_px) + 0.5));
}
