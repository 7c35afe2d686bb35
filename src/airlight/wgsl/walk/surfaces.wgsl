// Samples where surfaces are looked for: on the lattice, where the ray enters and leaves a block that may hold one, and between.

import package::blocks::{Way, way_from, step_on};
import package::walk::{Ends, Fetched, Line, fetch, first_behind, is_idle, last_before, leapt, place_of};
import slot::blocks::leap_of;
import slot::integrate::Accumulated;

// Into so many pieces the way through a block is cut: less than a voxel long in the mean.
const PIECES = 3.0;

// The slab that a ray is at, the number of the next sample of the lattice, the block that the ray is in, and the piece of it that
// comes next. `idled`: slabs without effect were passed over, so that the front is no back of a slab that was drawn.
struct Walk { front: Fetched, next: Fetched, k: f32, samples: f32, idled: bool, hid: bool, way: Way, piece: f32 }

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  walk.front = fetch(line, line.enter);
  walk.k = first_behind(line);
  walk.samples = 1.0;
  walk.way = way_from(line.index.origin, line.index.direction, line.enter);
  walk.piece = 1.0;
  return walk;
}

// On to the next slab with a surface, or the last one.
fn walk_on(walk: ptr<function, Walk>, line: Line, acc: ptr<function, Accumulated>) {
  var w = *walk;
  w.idled = false;
  loop {
    if (leap_of(w.way.block) > 0.0) {
      w.idled = true;
      w.way = leapt(w.way, line.leave);
      w.piece = 1.0;
      if (w.way.begin < line.leave) { w.front = fetch(line, w.way.begin); }
      w.k = last_before(line, min(w.way.begin, line.leave)) + 1.0;
      w.samples += 1.0;
    }
    var leaves = false;
    var idle = false;
    loop {
      let on_lattice = place_of(line, w.k);
      let in_block = mix(w.way.begin, w.way.end, w.piece / PIECES);
      w.next = fetch(line, min(min(on_lattice, in_block), line.leave));
      w.samples += 1.0;
      w.k += f32(on_lattice <= in_block);
      w.piece += f32(in_block <= on_lattice);
      if (w.piece > PIECES) {
        w.way = step_on(w.way, 1.0);
        w.piece = 1.0;
        leaves = leap_of(w.way.block) > 0.0;
      }
      idle = is_idle(line, w.front, w.next);
      if (w.next.t_world >= line.leave || !idle || leaves) { break; }
      w.front = w.next;
      w.idled = true;
    }
    if (w.next.t_world >= line.leave || !idle) { break; }
    w.front = w.next;
    w.idled = true;
  }
  *walk = w;
}

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends { return Ends(walk.front, walk.next); }
