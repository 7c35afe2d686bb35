// All cells of eight voxels that the ray passes through in blocks that may hold the surface, whatever the step: where roots are exact
// none is left out. To ask the eight voxels first takes longer than the two samples more that tell the cubic.

import generated::sizes::{DRAWS_CAPS, LIGHTS_FACES};
import package::blocks::{Run, least, pace_of, way_of};
import package::ray::INFINITE;
import package::refine::{Rise, beyond_between, may_rise, rise_of, root_of};
import package::walk::{Ends, Fetched, Line, fetch, is_idle, run_behind, sample_of};
import slot::integrate::{Accumulated, level};
import slot::values::{is_gap, scalar_of, with_scalar};

// The slab that a ray is at, within one cell; the way through the block that the ray is in; and distances at which the ray leaves the
// cell along each axis [world]. Nothing is known of fronts. A surface in the slab lies at its back.
struct Walk { front: Fetched, next: Fetched, samples: f32, idled: bool, hid: bool, run: Run, faces: vec3f }

// Whether others ask for what lies where the ray enters.
const KNOWS_ENTRY = LIGHTS_FACES || DRAWS_CAPS;

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  walk.front.t_world = line.enter;
  if (KNOWS_ENTRY) { walk.front = fetch(line, line.enter); }
  walk.samples = f32(KNOWS_ENTRY);
  walk.run = Run(line.enter, line.enter);
  return walk;
}

// On to the next slab with a surface, or the last one.
fn walk_on(walk: ptr<function, Walk>, line: Line, acc: ptr<function, Accumulated>) {
  var w = *walk;
  let iso = level(sample_of(line, w.front), sample_of(line, w.front));
  let way = way_of(line.index.origin, line.index.direction);
  let pace = pace_of(line.index.direction);
  let across = select(vec3f(0.0), abs(pace.rate), pace.along);
  var rise: Rise;
  var rises = false;
  loop {
    var beyond = vec4f(0.0);
    loop {
      if (w.front.t_world >= w.run.end) {
        let t_before = w.run.end;
        w.run = run_behind(line, way, t_before);
        if (w.run.begin > t_before || w.samples == 0.0) {
          w.front = fetch(line, w.run.begin);
          w.samples += 1.0;
        }
        let low = floor(line.index.origin + (w.run.begin + pace.beyond) * line.index.direction);
        let face = low + select(vec3f(0.0), vec3f(1.0), pace.up);
        w.faces = select(vec3f(INFINITE), (face - line.index.origin) * pace.rate, pace.along);
      }
      var stops = false;
      loop {
        let end = min(max(least(w.faces), w.front.t_world), w.run.end);
        w.next = fetch(line, end);
        w.samples += 1.0;
        w.faces += select(vec3f(0.0), across, w.faces <= vec3f(end));
        beyond = beyond_between(line.index.origin, line.index.direction, near_of(w), far_of(w), iso);
        stops = may_rise(beyond) || end >= line.leave || !is_idle(line, w.front, w.next);
        if (stops) { break; }
        w.front = w.next;
        if (end >= w.run.end) { break; }
      }
      if (stops) { break; }
    }
    rise = rise_of(beyond, w.front.t_world, w.next.t_world);
    rises = rise.piece.y >= 0.0 && !is_gap(w.front.value);
    if (rises || w.next.t_world >= line.leave || !is_idle(line, w.front, w.next)) { break; }
    w.front = w.next;
  }
  if (rises) {
    let root = root_of(rise);
    let below = iso - max(abs(iso) * JUST_BELOW, LEAST);
    w.next = Fetched(with_scalar(w.next.value, select(below, iso, scalar_of(w.front.value) < iso)), root);
  }
  *walk = w;
}

fn near_of(walk: Walk) -> vec2f { return vec2f(walk.front.t_world, scalar_of(walk.front.value)); }

// What is empty counts as what lies before it.
fn far_of(walk: Walk) -> vec2f {
  let value = select(scalar_of(walk.next.value), scalar_of(walk.front.value), is_gap(walk.next.value));
  return vec2f(walk.next.t_world, value);
}

// The value at a surface that is met on the way down, as a share of what it is told by.
const JUST_BELOW = 1.2e-7;
const LEAST = 1e-37;

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends { return Ends(walk.front, walk.next); }
