// Samples at equal distances from the eye.

import generated::sizes::{ADAPTIVE, BLOCKS_KNOW_MORE, CROSSES_EVEN, CURVED, HAS_CROSSINGS, LIT, SKIPS_BLOCKS};
import package::blocks::{just_behind, leaves, way_of};
import package::curved::curved_value;
import package::walk::{Ends, Fetched, Line, fetch, fetch_at, fetch_near, first_behind, is_hidden, is_idle, last_before, next_block};
import slot::blocks::even_of;
import slot::integrate::{Accumulated, through};
import slot::values::is_gap;

// The slab that a ray is at, and the number of the sample behind it. `idled` and `hid`: slabs without effect were passed over,
// the last of them empty or hidden, so that its front is no back of a slab that was drawn.
// `before` and `ahead`, where values are put right for curvature: the last sample as it was, and the one ahead; `found` is the
// front as it was. `leaps`: the block is to be looked at; `looked`: so many slabs ago it was. `lands`: so many samples to come make
// a front anew, behind a leap from the sample with the number `left`.
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
  looked: u32,
  lands: u32,
  left: f32,
  pace: f32,
}

// So many slabs without effect are passed one by one between looks at blocks.
const RUN = 4u;
// Slabs are so many steps long at most.
const LONGEST = 8.0;
// So many samples make a front anew.
const LANDING = select(1u, 3u, CURVED);
const NOWHERE = -3.4e38;

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  walk.front = fetch(line, line.enter);
  walk.k = first_behind(line);
  walk.samples = 1.0;
  walk.leaps = SKIPS_BLOCKS;
  walk.before = walk.front;
  walk.pace = 1.0;
  if (CURVED) { walk.ahead = fetch_near(line, walk.k); }
  // Where a part of a ray goes on from another, its first sample is moved as the last of that one was.
  if (CURVED && line.begin < line.enter) {
    walk.front.value = curved_value(fetch_near(line, walk.k - 2.0), walk.front, walk.ahead);
  }
  return walk;
}

// On to the next slab that matters, or the last one. A loop of its own: wide processors run the rest for all rays at once.
fn walk_on(walk: ptr<function, Walk>, line: Line, acc: ptr<function, Accumulated>) {
  var w = *walk;
  w.idled = false;
  w.hid = false;
  if (ADAPTIVE) { w.pace = pace_at(through(*acc)); }
  loop {
    if (SKIPS_BLOCKS && w.leaps && leap(&w, line)) { break; }
    if (CROSSES_EVEN && w.lands == 0u) { cross(&w, line); }
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
    if (BLOCKS_KNOW_MORE && !idle) { look_again(&w, run + 1u); }
    if (idle && SKIPS_BLOCKS && LIT) { continue; }
    // Slabs that are soon taken are, with nothing in them: on wide processors no ray waits for one that looks further.
    if (idle || !is_hidden(line, w.front, w.next)) { break; }
    w.front = w.next;
    w.hid = true;
  }
  *walk = w;
}

// Through blocks of one medium to the last sample in them, and to the one before where values are put right for curvature, so that
// none is by what lies outside.
fn cross(walk: ptr<function, Walk>, line: Line) {
  let before = select(0.0, (*walk).pace * line.spacing.step_world, CURVED);
  let last = last_before(line, min(even_until(line, (*walk).front.t_world - before), line.leave));
  let k = (*walk).pace * floor((last - select(0.0, 1.0, CURVED)) / (*walk).pace);
  if (k > (*walk).k) {
    (*walk).k = k;
    if (CURVED) { (*walk).ahead = fetch_near(line, k); }
    (*walk).samples += f32(CURVED);
  }
}

// How far a ray stays in blocks of one medium, from a distance on. It keeps off their outer faces, where rounding may tell others.
fn even_until(line: Line, t_world: f32) -> f32 {
  let way = way_of(line.index.origin, line.index.direction);
  var t = t_world - way.beyond;
  loop {
    let block = floor(way.origin + t * way.direction);
    let reach = even_of(block);
    if (reach == 0.0 || t >= line.leave) { break; }
    t = just_behind(way, max(leaves(way, block, reach), t));
  }
  return t - 2.0 * way.beyond;
}

// Where slabs do not tell that a block is empty it is looked at once in a while.
fn look_again(walk: ptr<function, Walk>, slabs: u32) {
  (*walk).looked += slabs;
  (*walk).leaps = (*walk).looked >= RUN;
  if ((*walk).leaps) { (*walk).looked = 0u; }
}

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends {
  if (CURVED) { return Ends(walk.found, walk.before); }
  return Ends(walk.front, walk.next);
}

// The number of the sample behind the next one.
fn behind(walk: Walk) -> f32 {
  if (!ADAPTIVE) { return walk.k + 1.0; }
  return walk.pace * (floor(walk.k / walk.pace) + 1.0);
}

// Length of slabs in steps, a power of two: what a slab is off by grows as the square of its length, and falls with what gets
// through to it.
fn pace_at(through: f32) -> f32 {
  return select(1.0, 2.0, through <= 0.25) * select(1.0, 2.0, through <= 0.0625) * select(1.0, 2.0, through <= 0.015625);
}

// The sample behind the front.
fn step(walk: ptr<function, Walk>, line: Line) {
  var next: Fetched;
  if (CURVED) {
    next = (*walk).ahead;
    (*walk).ahead = fetch_near(line, behind(*walk));
    let value = curved_value((*walk).before, next, (*walk).ahead);
    (*walk).found = (*walk).before;
    (*walk).before = next;
    next.value = value;
  } else {
    next = fetch_at(line, (*walk).k);
  }
  (*walk).next = next;
  (*walk).k = behind(*walk);
  (*walk).samples += 1.0;
}

// Over blocks in which nothing is, to the last sample before the others; whether there are none.
fn leap(walk: ptr<function, Walk>, line: Line) -> bool {
  let begin = next_block(line, (*walk).front.t_world, line.leave);
  (*walk).leaps = false;
  let k = (*walk).pace * floor(last_before(line, begin) / (*walk).pace);
  if (k >= (*walk).k) {
    (*walk).left = (*walk).pace * (ceil((*walk).k / (*walk).pace) - 1.0);
    (*walk).k = k - (*walk).pace * f32(LANDING - 1u);
    (*walk).lands = LANDING;
  }
  if (begin >= line.leave) {
    // A last slab without length, since its front may hold something that is hidden.
    (*walk).front.t_world = line.leave;
    (*walk).next = (*walk).front;
    (*walk).found = (*walk).front;
    (*walk).before = (*walk).front;
  }
  return begin >= line.leave;
}

// One of the samples of a landing. Rounding and curvature may move the last one off the values at which nothing is, or on to others
// of the kind: then back to where the leap began, and on step by step. Where blocks know more than samples it is taken as it is.
fn land(walk: ptr<function, Walk>, line: Line) {
  (*walk).lands -= 1u;
  if ((*walk).lands > 0u || (*walk).left == NOWHERE) { return; }
  if (BLOCKS_KNOW_MORE) {
    (*walk).hid = true;
    return;
  }
  let front = (*walk).front;
  var as_found = front;
  if (CURVED) { as_found = (*walk).before; }
  if (!is_idle(line, as_found, front) && !is_gap(front.value)) {
    (*walk).k = (*walk).left - (*walk).pace * f32(LANDING - 1u);
    (*walk).lands = LANDING;
    (*walk).left = NOWHERE;
  }
}
