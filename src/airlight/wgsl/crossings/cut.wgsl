// Surfaces of the transfer function cut a slab, the nearest first: the piece before one, then the surface. What is left is a slab as
// ever. They are told by what the field has at the ends, also where values are put right for curvature; none in a gap.

import generated::driver::REFINE;
import generated::sizes::{CURVED, HAS_EMPTY};
import package::faces::Face;
import package::front::{Front, lit_sheet, lit_slab};
import package::optics::{thicker, tinted};
import package::refine::refined;
import package::sample::{Part, Sample, Sheet, Slab};
import package::walk::{Ends, Line, fetch, sample_of};
import slot::integrate::{Accumulated, take};
import slot::transfer::{classify_known, know_crossing, next_crossing};
import slot::values::{is_gap, scalar_of, with_scalar};

// Take the surfaces of a slab with the pieces before them; the front moves on to the last of them, and the length [world] is what is
// left behind it. `ends` are as the field has them. Whether the ray ends there.
fn take_crossings(
  acc: ptr<function, Accumulated>, front: ptr<function, Front>, back: Sample, length: ptr<function, f32>,
  ends: Ends, line: Line, face: Face, part: Part, thinning: f32,
) -> bool {
  // Where the field turns between the ends it is met twice: there the slab has two legs.
  var leg = sample_of(line, ends.front);
  let last = sample_of(line, ends.back);
  let is_cut = !HAS_EMPTY || !(is_gap(leg.value) || is_gap(last.value));
  var goal = leg;
  if (is_cut) { goal = last; }
  let turn = turn_of(scalar_of(leg.value), scalar_of(last.value), scalar_of((*front).here.value), scalar_of(back.value));
  var turns = is_cut && turn > 0.0 && turn < 1.0;
  loop {
    if (!turns) { break; }
    // Where nothing was moved past a surface, slabs may have been passed over: then never.
    turns = next_crossing(leg, (*front).here, 0u).share <= 1.0 || next_crossing(last, back, 0u).share <= 1.0;
    if (turns) { goal = sample_of(line, fetch(line, mix(leg.t_world, last.t_world, turn))); }
    break;
  }
  var near = leg;
  var passed = 0u;
  var ended = false;
  loop {
    let sheet = next_crossing(leg, goal, passed);
    if (sheet.share > 1.0) {
      if (!turns) { break; }
      turns = false;
      leg = goal;
      near = goal;
      goal = last;
      passed = 0u;
      continue;
    }
    let hit = hit_of(sheet, line, leg, near, goal);
    let way = max(hit.t_world - (*front).here.t_world, 0.0);
    var slab = tinted(classify_known((*front).here, (*front).known, hit, know_crossing(sheet, hit, false), way * thinning), part.rgb);
    var lit_rgb = lit_slab(front, hit, slab, face, line.ray);
    ended = take(acc, (*front).here, hit, slab, lit_rgb, way);
    let alpha = 1.0 - thicker(1.0 - sheet.alpha, thinning);
    slab = Slab(alpha * sheet.rgb * part.rgb, alpha, vec3f(0.0), 0.0, alpha);
    lit_rgb = lit_sheet(front, hit, slab, line.ray);
    ended = ended || take(acc, hit, hit, slab, lit_rgb, 0.0);
    if (ended) { break; }
    near = hit;
    (*front).known = know_crossing(sheet, hit, true);
    *length = max(back.t_world - hit.t_world, 0.0);
    passed++;
  }
  return ended;
}

// The share of a slab at which the parabola through its ends turns that curvature has moved by a sixth of their distance from the
// lines between their neighbours; outside of 0 to 1 where it does not.
fn turn_of(front: f32, back: f32, moved_front: f32, moved_back: f32) -> f32 {
  let bend = 6.0 * (moved_front - front + moved_back - back);
  if (!CURVED || bend == 0.0) { return 2.0; }
  return 0.5 + (back - front) / bend;
}

// Where a slab meets a surface of the transfer function; `front` is the surface before it, or the front of the whole slab.
fn hit_of(sheet: Sheet, line: Line, whole: Sample, front: Sample, back: Sample) -> Sample {
  var t_world = mix(whole.t_world, back.t_world, sheet.share);
  if (REFINE > 0u) {
    let near = vec2f(front.t_world, scalar_of(front.value));
    let far = vec2f(back.t_world, scalar_of(back.value));
    t_world = refined(line.index.origin, line.index.direction, near, far, sheet.level);
  }
  var hit = sample_of(line, fetch(line, t_world));
  hit.value = with_scalar(hit.value, sheet.level);
  return hit;
}
