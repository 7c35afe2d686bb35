// What of a ray is marched: the pieces that clips keep, up to the nearest opaque mesh. And meshes in between.

import generated::sizes::{CUTS_AT_COVERS, FILLS, IN_PARTS, SKIPS_BLOCKS};
import package::cover::Cover;
import package::kept::Kept;
import package::sample::{Sample, Slab};
import package::walk::{Line, border_before, kept_of, next_block};
import slot::clips::HAS_CLIPS;
import slot::covers::{HAS_COVERS, cover_at};
import slot::integrate::{Accumulated, take};

// Where a ray ends [world].
fn end_of(line: Line, at: u32) -> f32 {
  if (!HAS_COVERS) { return line.leave; }
  return min(line.leave, cover_at(at, 0u).t_world);
}

// The next piece that clips keep, at a distance [world] or behind it; one without length where there is none. Pieces in which nothing
// is are passed over, unless they show that there is nothing.
fn next_kept(line: Line, t_world: f32, t_leave: f32) -> Kept {
  var kept = Kept(t_world, t_world, 0u, 0u);
  loop {
    kept = kept_of(line, kept.end, t_leave);
    if (!HAS_CLIPS || !SKIPS_BLOCKS || FILLS || kept.begin >= kept.end || next_block(line, kept.begin, kept.end) < kept.end) { break; }
  }
  return kept;
}

// Where the slabs begin [world] of which those from a distance on are the rest: at a cut, a border of layers, or a mesh.
fn begin_of(line: Line, kept: Kept, at: u32, covers_taken: u32, t_world: f32) -> f32 {
  var begin = kept.begin;
  if (IN_PARTS) {
    begin = max(begin, border_before(line, t_world));
    if (CUTS_AT_COVERS && covers_taken > 1u) { begin = max(begin, cover_at(at, covers_taken - 1u).t_world); }
  }
  return min(begin, t_world);
}

// Take the meshes that let light pass up to a distance, from one number on; return the distance of the next, at which slabs end.
fn take_covers(acc: ptr<function, Accumulated>, at: u32, number: ptr<function, u32>, t_world: f32, t_leave: f32) -> f32 {
  var cover = cover_at(at, *number);
  loop {
    if (cover.t_world > t_world || t_world >= t_leave) { break; }
    take_cover(acc, cover);
    *number += 1u;
    cover = cover_at(at, *number);
  }
  return cover.t_world;
}

// A mesh that lets light pass is a slab without length.
fn take_cover(acc: ptr<function, Accumulated>, cover: Cover) {
  var here: Sample;
  here.t_world = cover.t_world;
  take(acc, here, here, Slab(cover.rgb, 0.0, vec3f(0.0), 0.0, cover.alpha), cover.rgb, 0.0);
}
