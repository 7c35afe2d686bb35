// A pass over a picture: what its stage makes of each pixel.

import generated::frame::frame;
import generated::picture::written;
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::picture::here_px;
import slot::passes::pixel;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= frame.tile_size_px)) { return; }
  let at_px = frame.tile_origin_px + id.xy;
  here_px = vec2i(at_px);
  written[(at_px.y - frame.band_first_row) * frame.size_px.x + at_px.x] = pixel(vec2i(at_px));
}
