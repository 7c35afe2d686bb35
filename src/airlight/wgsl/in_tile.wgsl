// From places on the image, whose edges are at -1 and 1, to those on the part of it that is drawn.

import generated::frame::frame;

fn in_tile(place: vec4f) -> vec4f {
  let down = vec2f(1.0, -1.0);
  let p_px = 0.5 * vec2f(frame.size_px) * (down * place.xy + place.w);
  let here = (p_px - vec2f(frame.tile_origin_px) * place.w) / vec2f(frame.tile_size_px);
  return vec4f(down * (2.0 * here - place.w), place.zw);
}
