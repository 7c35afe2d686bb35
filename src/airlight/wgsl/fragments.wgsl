// Triangles that the rays of a tile's pixels meet, in no order: for each pixel how many, and places for `frame.fragment_slots`.

import generated::frame::frame;

// The triangle's number among all that are drawn; the highest bit is set where its front is seen.
const FRONT = 0x80000000u;

fn fragment_place(in_tile: vec2u, slot: u32) -> u32 {
  return (slot * frame.tile_size_px.y + in_tile.y) * frame.tile_size_px.x + in_tile.x;
}
