// Rays from the first face of the blocks that hold something to the last one, as a rasteriser has met them (Scharsach, section 6).

import generated::frame::frame;
import generated::pass::{reach_first, reach_last};
import generated::sizes::CURVED;
import package::walk::{Line, sample_number, place_of};

// A thousandth of a sample beyond, since faces are met with rounding.
const BEYOND = 1e-3;

// Samples stay where they are: rays begin and end at one, beyond what it takes to move the next for curvature.
fn bounded(line: Line, pixel: vec2u) -> Line {
  let place = vec2i(pixel - vec2u(0u, frame.band_first_row));
  let first = textureLoad(reach_first, place, 0).r;
  let last = textureLoad(reach_last, place, 0).r;
  let before = select(1.0, 3.0, CURVED);
  var part = line;
  part.enter = max(line.enter, place_of(line, floor(sample_number(line, first) - BEYOND) - before + 1.0));
  part.leave = min(line.leave, place_of(line, ceil(sample_number(line, last) + BEYOND) + before - 1.0));
  if (last < first) { part.leave = part.enter; }
  part.begin = part.enter;
  part.end = part.leave;
  return part;
}
