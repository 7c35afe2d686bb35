// Samples at equal distances from the eye.

import generated::sizes::{CURVED, HAS_CROSSINGS, SKIPS_BLOCKS};
import package::blocks::way_from;
import package::curved::curved_value;
import package::walk::{Ends, Fetched, Line, fetch, fetch_at, is_hidden, is_idle, last_before, leapt};
import slot::values::is_gap;

// The slab that a ray is at, and the number of the sample behind it. `idled` and `hid`: slabs without effect were passed over,
// the last of them empty or hidden, so that its front is no back of a slab that was drawn.
// `before` and `ahead`, where values are put right for curvature: the last sample as it was, and the one ahead; `found` is the
// front as it was. `lands`: so many samples to come make a front anew, behind a leap from the sample with the number `left`.
struct Walk {
  front: Fetched,
  next: Fetched,
  found: Fetched,
  before: Fetched,
  ahead: Fetched,
  k: f32,
  samples: f32,
  idled: bool,
  hid: bool,
  leaps: bool,
  lands: u32,
  left: f32,
}

// So many slabs without effect are passed one by one between looks at blocks.
const RUN = 4u;
// So many samples make a front anew.
const LANDING = select(1u, 3u, CURVED);
const NOWHERE = -3.4e38;

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  walk.front = fetch(line, line.enter);
  walk.k = last_before(line, line.enter) + 1.0;
  walk.samples = 1.0;
  walk.leaps = SKIPS_BLOCKS;
  walk.before = walk.front;
  if (CURVED) { walk.ahead = fetch_at(line, walk.k); }
  return walk;
}

// On to the next slab that matters, or the last one. A loop of its own: wide processors run the rest for all rays at once.
fn walk_on(walk: ptr<function, Walk>, line: Line) {
  var w = *walk;
  w.idled = false;
  w.hid = false;
  loop {
    if (SKIPS_BLOCKS && w.leaps && leap(&w, line)) { break; }
    var idle = false;
    var run = 0u;
    loop {
      step(&w, line);
      let lands = w.lands > 0u;
      idle = lands || is_idle(line, w.front, w.next);
      if (CURVED && HAS_CROSSINGS && !lands) {
        // Neither as found nor as moved, nor by the move, does an end pass a surface.
        idle = idle && is_idle(line, w.found, w.before) && is_idle(line, w.found, w.next);
      }
      if (!lands && (w.next.t_world >= line.leave || !idle)) { break; }
      w.front = w.next;
      w.idled = true;
      w.hid = false;
      if (lands) { land(&w, line); }
      run += u32(!lands);
      if (SKIPS_BLOCKS && run >= RUN) { break; }
    }
    if (w.next.t_world >= line.leave) { break; }
    w.leaps = SKIPS_BLOCKS && idle;
    if (w.leaps) { continue; }
    if (!is_hidden(line, w.front, w.next)) { break; }
    w.front = w.next;
    w.hid = true;
  }
  *walk = w;
}

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends {
  if (CURVED) { return Ends(walk.found, walk.before); }
  return Ends(walk.front, walk.next);
}

// The sample behind the front.
fn step(walk: ptr<function, Walk>, line: Line) {
  var next: Fetched;
  if (CURVED) {
    next = (*walk).ahead;
    (*walk).ahead = fetch_at(line, (*walk).k + 1.0);
    let value = curved_value((*walk).before, next, (*walk).ahead);
    (*walk).found = (*walk).before;
    (*walk).before = next;
    next.value = value;
  } else {
    next = fetch_at(line, (*walk).k);
  }
  (*walk).next = next;
  (*walk).k += 1.0;
  (*walk).samples += 1.0;
}

// Over blocks in which nothing is, to the last sample before the others; whether there are none.
fn leap(walk: ptr<function, Walk>, line: Line) -> bool {
  let way = leapt(way_from(line.index.origin, line.index.direction, (*walk).front.t_world), line.leave);
  (*walk).leaps = false;
  let k = last_before(line, way.begin);
  if (k >= (*walk).k) {
    (*walk).left = (*walk).k - 1.0;
    (*walk).k = k - f32(LANDING - 1u);
    (*walk).lands = LANDING;
  }
  if (way.begin >= line.leave) {
    (*walk).next = (*walk).front;
    (*walk).next.t_world = line.leave;
  }
  return way.begin >= line.leave;
}

// One of the samples of a landing. Rounding and curvature may move the last one off the values at which nothing is, or on to others
// of the kind: then back to where the leap began, and on step by step.
fn land(walk: ptr<function, Walk>, line: Line) {
  (*walk).lands -= 1u;
  if ((*walk).lands > 0u || (*walk).left == NOWHERE) { return; }
  let front = (*walk).front;
  var as_found = front;
  if (CURVED) { as_found = (*walk).before; }
  if (!is_idle(line, as_found, front) && !is_gap(front.value)) {
    (*walk).k = (*walk).left - f32(LANDING - 1u);
    (*walk).lands = LANDING;
    (*walk).left = NOWHERE;
  }
}
