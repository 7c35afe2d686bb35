// A triangle that a pixel meets in front of what is opaque, among those that the pixel keeps.

import generated::frame::frame;
import generated::mesh::params;
import generated::pass::{fragments, fragment_counts, most_fragments, opaque_depth};
import package::corner::Corner;
import package::fragments::{FRONT, fragment_place};
import slot::seen::is_cut;

fn gather(at: Corner, depth: f32, is_front: bool) {
  let in_tile = vec2u(at.place.xy);
  if (depth <= textureLoad(opaque_depth, in_tile, 0) || is_cut(at)) { return; }
  let slot = atomicAdd(&fragment_counts[fragment_place(in_tile, 0u)], 1u);
  if (slot >= frame.fragment_slots) {
    atomicMax(&most_fragments[0], slot + 1u);
    return;
  }
  fragments[fragment_place(in_tile, slot)] = (params.first_triangle + at.triangle) | select(0u, FRONT, is_front);
}
