// All cells of eight voxels that the ray passes through in blocks that may hold the surface, whatever the step: where roots are exact
// none is left out. To ask the eight voxels first takes longer than the two samples more that tell the cubic.

import package::blocks::{Way, least, step_on, way_from};
import package::ray::INFINITE;
import package::refine::beyond_in_cell;
import package::walk::{Ends, Fetched, Line, fetch, is_idle, leapt, sample_of};
import slot::blocks::leap_of;
import slot::integrate::{Accumulated, level};
import slot::values::{is_gap, scalar_of, with_scalar};

// The slab that a ray is at, within one cell, and the block and the cell that it is in. Nothing is known of fronts.
struct Walk { front: Fetched, next: Fetched, samples: f32, idled: bool, hid: bool, way: Way, cell: Cell }

// The cell above a voxel, where the ray leaves it, and distances between its faces [world].
struct Cell { low: vec3f, end: f32, pace: vec3f }

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  walk.front = fetch(line, line.enter);
  walk.samples = 1.0;
  walk.way = way_from(line.index.origin, line.index.direction, line.enter);
  walk.cell = cell_from(line, line.enter);
  return walk;
}

fn cell_from(line: Line, t_world: f32) -> Cell {
  let p = line.index.origin + t_world * line.index.direction;
  // A ray on a face is in the cell that it goes into.
  let low = select(floor(p), ceil(p) - 1.0, line.index.direction < vec3f(0.0));
  let pace = select(1.0 / line.index.direction, vec3f(INFINITE), abs(line.index.direction) < vec3f(1e-30));
  return Cell(low, least(ends_of_cell(line, low, pace)), pace);
}

// Distances at which the ray leaves a cell, along each axis.
fn ends_of_cell(line: Line, low: vec3f, pace: vec3f) -> vec3f {
  let face = low + select(vec3f(0.0), vec3f(1.0), line.index.direction > vec3f(0.0));
  return select((face - line.index.origin) * pace, vec3f(INFINITE), pace >= vec3f(INFINITE));
}

// On to the next slab with a surface, or the last one.
fn walk_on(walk: ptr<function, Walk>, line: Line, acc: ptr<function, Accumulated>) {
  var w = *walk;
  loop {
    if (leap_of(w.way.block) > 0.0) {
      w.way = leapt(w.way, line.leave);
      w.front = fetch(line, min(w.way.begin, line.leave));
      w.cell = cell_from(line, w.front.t_world);
      w.samples += 1.0;
    }
    let iso = level(sample_of(line, w.front), sample_of(line, w.front));
    var stops = false;
    loop {
      w.samples += 1.0;
      w.next = next_side(line, w.front, fetch(line, min(w.cell.end, line.leave)), iso);
      stops = w.next.t_world >= line.leave || !is_idle(line, w.front, w.next);
      if (stops) { break; }
      w.front = w.next;
      if (on_to_next_cell(&w, line)) { break; }
    }
    if (stops) { break; }
  }
  *walk = w;
}

// Whether the block behind the cell may be passed over. Through an edge several faces are left at once.
fn on_to_next_cell(walk: ptr<function, Walk>, line: Line) -> bool {
  let cell = (*walk).cell;
  let is_left = ends_of_cell(line, cell.low, cell.pace) <= vec3f(cell.end);
  let low = cell.low + select(vec3f(0.0), sign(line.index.direction), is_left);
  (*walk).cell = Cell(low, max(cell.end, least(ends_of_cell(line, low, cell.pace))), cell.pace);
  if (cell.end < (*walk).way.end) { return false; }
  (*walk).way = step_on((*walk).way, 1.0);
  return leap_of((*walk).way.block) > 0.0;
}

// The second of two samples, or what is on the other side of the surface between two on one side: the field turns there.
fn next_side(line: Line, front: Fetched, next: Fetched, iso: f32) -> Fetched {
  let near = vec2f(front.t_world, scalar_of(front.value));
  let far = vec2f(next.t_world, select(scalar_of(next.value), near.y, is_gap(next.value)));
  let beyond = beyond_in_cell(line.index.origin, line.index.direction, near, far, iso);
  let on_one_side = (near.y >= iso) == (far.y >= iso);
  if (is_gap(front.value) || !on_one_side || beyond.x <= near.x || beyond.x >= far.x) { return next; }
  return Fetched(with_scalar(next.value, beyond.y), beyond.x);
}

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends { return Ends(walk.front, walk.next); }
