// Where pixels lie in the lists that a pass reads.

import generated::frame::frame;
import generated::picture::params;

var<private> here_px: vec2i;  // the pixel that is made

// Of a pixel, or of the nearest one that is in the image and as near as the pass tells that it looks.
fn place(p_px: vec2i) -> u32 {
  let near = clamp(p_px, here_px - params.reach_px, here_px + params.reach_px);
  let size_px = vec2i(frame.size_px);
  let inside = clamp(near, vec2i(0), size_px - 1);
  return u32((inside.y - params.first_row) * size_px.x + inside.x);
}
