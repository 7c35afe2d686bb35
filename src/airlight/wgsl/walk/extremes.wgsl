// Samples at equal distances from the eye where a value along the ray is looked for: blocks whose values cannot change what has
// been found are passed over.

import generated::sizes::{BOUND_GROUP_VOXELS, BOUND_VOXELS};
import package::blocks::{pace_of, past};
import package::sample::Slab;
import package::walk::{Ends, Fetched, Line, fetch, fetch_at, first_behind, last_before, sample_of};
import slot::blocks::bounds_of;
import slot::integrate::{Accumulated, settled, take};

// The last slab, and the number of the sample behind it.
struct Walk { front: Fetched, next: Fetched, k: f32, samples: f32, idled: bool, hid: bool }

// So many slabs are taken between looks at blocks. All are, whether they matter or not: rays that stay together are faster.
const RUN = 8u;

fn begin_walk(line: Line) -> Walk {
  var walk: Walk;
  walk.front = fetch(line, line.enter);
  walk.k = first_behind(line);
  walk.samples = 1.0;
  return walk;
}

// To the last slab, which is left to be taken; one that ends the ray changes nothing when it is taken again.
fn walk_on(walk: ptr<function, Walk>, line: Line, acc: ptr<function, Accumulated>) {
  var w = *walk;
  loop {
    var stops = false;
    var run = 0u;
    loop {
      w.next = fetch_at(line, w.k);
      w.k += 1.0;
      run += 1u;
      if (w.next.t_world >= line.leave) { break; }
      let front = sample_of(line, w.front);
      let back = sample_of(line, w.next);
      stops = take(acc, front, back, Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0), vec3f(0.0), back.t_world - front.t_world);
      if (stops || run >= RUN) { break; }
      w.front = w.next;
    }
    w.samples += f32(run);
    if (stops || w.next.t_world >= line.leave) { break; }
    let begin = begin_behind(line, acc, w.next.t_world);
    w.front = w.next;
    w.next.t_world = line.leave;
    if (begin >= line.leave) { break; }
    let k = last_before(line, begin);
    if (k >= w.k) {
      w.front = fetch_at(line, k);
      w.k = k + 1.0;
      w.samples += 1.0;
    }
  }
  *walk = w;
}

// Where, from a distance on, a ray meets the first block whose values may matter.
fn begin_behind(line: Line, acc: ptr<function, Accumulated>, t_world: f32) -> f32 {
  let pace = pace_of(line.index.direction);
  var t = t_world + pace.beyond;
  loop {
    let p = line.index.origin + t * line.index.direction;
    let bounds = bounds_of(floor(p / f32(BOUND_VOXELS)));
    let group = settled(acc, bounds.y, t);
    if (t >= line.leave || !(group || settled(acc, bounds.x, t))) { break; }
    let side = select(f32(BOUND_VOXELS), f32(BOUND_GROUP_VOXELS), group);
    let low = floor(p / side) * side;
    t = past(pace, p, t, low, low + side);
  }
  return t - pace.beyond;
}

// The ends of the slab with the values that the field has there.
fn ends_of(walk: Walk) -> Ends { return Ends(walk.front, walk.next); }
