// Which place of a tile a thread draws.

import generated::frame::frame;
import generated::sizes::{GROUP_X, GROUP_Y, WORKGROUP_Y};

// Software devices give each processor one stretch of groups: rows of these are dealt out in turn, so that all get as much to do.
fn place_in_tile(group: vec2u, thread: u32) -> vec2u {
  let rows = (frame.tile_size_px.y + GROUP_Y * frame.strands - 1u) / (GROUP_Y * frame.strands);
  let row = (group.y % rows) * frame.strands + group.y / rows;
  return vec2u(GROUP_X, GROUP_Y) * vec2u(group.x, row) + place_in_group(thread);
}

// Row by row. Or two columns at a time where the pixels that a processor draws at once, threads in a row, had better lie close
// together, since all wait for the longest of their rays.
fn place_in_group(thread: u32) -> vec2u {
  if (GROUP_Y == WORKGROUP_Y) { return vec2u(thread % GROUP_X, thread / GROUP_X); }
  return vec2u((thread & 1u) + 2u * (thread / (2u * GROUP_Y)), (thread >> 1u) % GROUP_Y);
}
