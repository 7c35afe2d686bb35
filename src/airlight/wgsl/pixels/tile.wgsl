// Pixels of a tile, all of them.

import generated::frame::frame;

fn pixel_at(place: vec2u) -> vec2u { return frame.tile_origin_px + place; }
