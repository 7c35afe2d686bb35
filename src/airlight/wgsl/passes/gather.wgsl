// All triangles at each pixel in front of what is opaque, in one pass.

import generated::frame::frame;
import generated::mesh::params;
import generated::pass::{fragments, fragment_counts, most_fragments, opaque_depth};
import package::fragments::{FRONT, fragment_place};
import package::raster::{Corner, corner_of};
import slot::seen::is_cut;

@vertex
fn at_corner(@location(0) p_mesh: vec3f, @builtin(vertex_index) number: u32) -> Corner { return corner_of(p_mesh, number); }

@fragment
fn nearest(at: Corner, @builtin(front_facing) is_front: bool) {
  let in_tile = vec2u(at.place.xy);
  if (at.place.z <= textureLoad(opaque_depth, in_tile, 0) || is_cut(at)) { return; }
  let slot = atomicAdd(&fragment_counts[fragment_place(in_tile, 0u)], 1u);
  if (slot >= frame.fragment_slots) {
    atomicMax(&most_fragments[0], slot + 1u);
    return;
  }
  fragments[fragment_place(in_tile, slot)] = (params.first_triangle + at.triangle) | select(0u, FRONT, is_front);
}
