// Samples where surfaces are looked for: where the ray enters and leaves a block that may hold one, and at equal distances between.

import generated::sizes::{CLASSIFIES, DRAWS_CAPS, LIGHTS_FACES};
import package::blocks::{Run, way_of};
import package::walk::{Ends, Fetched, Line, fetch, is_idle, run_behind};
import slot::integrate::Accumulated;

// No piece of the way through a block is longer than this, nor than a step; so much of a piece is taken for rounding.
const LONGEST_VOXELS = 1.4;
const ROUNDING = 1e-3;
// Whether others ask for what lies where the ray enters.
const KNOWS_ENTRY = CLASSIFIES || LIGHTS_FACES || DRAWS_CAPS;

// The slab that a ray is at, the way through the block that the ray is in, cut into pieces of a length, and the number of the piece
// that comes next: 0 where the front is to be found first. `idled`: slabs without effect were passed over, so that the front is no
// back of a slab that was drawn.
struct Walk { front: Fetched, next: Fetched, samples: f32, idled: bool, hid: bool, run: Run, length: f32, pieces: f32, piece: f32 }

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  if (KNOWS_ENTRY) { walk.front = fetch(line, line.enter); }
  walk.samples = f32(KNOWS_ENTRY);
  walk.run = Run(line.enter, line.enter);
  walk.pieces = 0.0;
  walk.piece = 1.0;
  return walk;
}

// On to the next slab with a surface, or the last one.
fn walk_on(walk: ptr<function, Walk>, line: Line, acc: ptr<function, Accumulated>) {
  var w = *walk;
  w.idled = false;
  let way = way_of(line.index.origin, line.index.direction);
  let pace = max(1.0 / line.spacing.step_world, length(line.index.direction) / LONGEST_VOXELS);
  loop {
    if (w.piece > w.pieces) {
      let t_before = w.run.end;
      w.run = run_behind(line, way, t_before);
      let run = w.run.end - w.run.begin;
      let finds_front = w.run.begin > t_before || (!KNOWS_ENTRY && w.pieces == 0.0);
      w.piece = select(1.0, 0.0, finds_front);
      w.pieces = max(ceil(run * pace - ROUNDING), 1.0);
      w.length = run / w.pieces;
    }
    var idle = false;
    loop {
      let t_world = select(w.run.begin + w.piece * w.length, w.run.end, w.piece >= w.pieces);
      w.next = fetch(line, min(t_world, line.leave));
      w.samples += 1.0;
      if (w.piece == 0.0) { w.front = w.next; }
      idle = w.piece == 0.0 || is_idle(line, w.front, w.next);
      w.piece += 1.0;
      if (w.next.t_world >= line.leave || !idle) { break; }
      w.front = w.next;
      w.idled = true;
      if (w.piece > w.pieces) { break; }
    }
    if (w.next.t_world >= line.leave || !idle) { break; }
  }
  *walk = w;
}

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends { return Ends(walk.front, walk.next); }
