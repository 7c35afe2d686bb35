// Pixels of a list, in rows of which tiles take pieces.

import generated::frame::frame;
import generated::pass::chosen;
import generated::sizes::CHOSEN_WIDTH;

fn pixel_at(place: vec2u) -> vec2u {
  let at = frame.tile_origin_px + place;
  let pixel = chosen[at.y * CHOSEN_WIDTH + at.x];
  return vec2u(pixel & 0xffffu, pixel >> 16u);
}
