// All triangles at each pixel in front of what is opaque, in one pass: for images that are no planes.

import package::boxes::{box_corner, meeting};
import package::corner::Corner;
import package::gathering::gather;

@vertex
fn at_corner(@builtin(vertex_index) number: u32) -> Corner { return box_corner(number); }

@fragment
fn nearest(at: Corner) {
  let here = meeting(at);
  if (here.is_met) { gather(at, here.depth, here.is_front); }
}
