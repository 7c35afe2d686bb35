// Which triangle of a mesh is the nearest at each pixel, by its number from 1 on, and of which mesh: for images that are no planes.

import generated::mesh::params;
import package::boxes::{box_corner, meeting};
import package::corner::Corner;
import slot::seen::is_cut;

struct Found { @location(0) numbers: vec2u, @builtin(frag_depth) depth: f32 }

@vertex
fn at_corner(@builtin(vertex_index) number: u32) -> Corner { return box_corner(number); }

@fragment
fn nearest(at: Corner) -> Found {
  let here = meeting(at);
  if (!here.is_met || is_cut(at)) { discard; }
  return Found(vec2u(at.triangle + 1u, params.number), here.depth);
}
