// Where a point lies on the part of the image that is drawn, for rasterisers.

import generated::frame::frame;
import slot::camera::clip_place;

fn on_tile(p_world: vec3f, near_world: f32, far_world: f32) -> vec4f {
  let place = clip_place(p_world, near_world, far_world, vec2f(frame.tile_origin_px) + 0.5);
  let down = vec2f(1.0, -1.0);
  let p_px = 0.5 * vec2f(frame.size_px) * (down * place.xy + place.w);
  let in_tile = (p_px - vec2f(frame.tile_origin_px) * place.w) / vec2f(frame.tile_size_px);
  return vec4f(down * (2.0 * in_tile - place.w), place.zw);
}
