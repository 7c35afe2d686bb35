// The ray march: one ray a pixel, slab by slab from the eye. There is no other march loop.

import generated::frame::frame;
import generated::driver::REFINE;
import generated::pass::{radiance, depth};
import generated::sizes::{CLASSIFIES, CUTS_AT_COVERS, DRAWS_CAPS, HAS_CROSSINGS, HAS_EMPTY, LIGHTS_ENDS, LIGHTS_FACES, SKIPS_EMPTY};
import generated::sizes::{CURVED, SURFACES_ONLY, WORKGROUP_X, WORKGROUP_Y};
import package::cover::{Cover, result_over};
import package::faces::{Face, cap_of, face_gradient, face_of, lit_behind, lit_cap};
import package::kept::Kept;
import package::ray::{Ray, INFINITE};
import package::optics::{thicker, tinted};
import package::refine::refined;
import package::sample::{Sample, Sheet, Slab, Result};
import package::walk::{Line, fetch, line_of, sample_of};
import slot::camera::eye_ray;
import slot::clips::{HAS_CLIPS, kept_from};
import slot::covers::{HAS_COVERS, cover_at};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::hits::{KEEPS_HITS, keep_hit};
import slot::transfer::{medium, Known, know, know_empty, classify_known, next_crossing, know_crossing};
import slot::lighting::{light_slab, LitEnd, know_light, light_known};
import slot::modulation::weight;
import slot::region::part_at;
import slot::integrate::{Accumulated, begin, take, finish, surface, level, surface_rgb};
import slot::tone::tone;
import slot::values::{is_gap, mix_values, scalar_of, with_scalar};
import slot::walk::{ends_of, begin_walk, walk_on};

const HALF_OPAQUE = 4.0;  // the side of what is kept where no surfaces are looked for

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  // Software devices give each processor one stretch of rows: dealt out in turn, all get as much to do.
  let rows = (frame.tile_size_px.y + frame.strands - 1u) / frame.strands;
  let place = vec2u(id.x, (id.y % rows) * frame.strands + id.y / rows);
  if (any(place >= frame.tile_size_px)) { return; }
  let pixel = frame.tile_origin_px + place;
  let p_px = vec2f(pixel) + 0.5;
  var samples = 0.0;
  var met = Met(0.0, 0.0, 0u);
  let line = line_of(eye_ray(p_px), pixel);
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let result = march(line, at, &samples, &met);
  radiance[at] = vec4f(tone(result.rgb, p_px), result.alpha);
  depth[at] = vec2f(result.t_world + frame.t_offset_world, samples);
  if (KEEPS_HITS) {
    if (!SURFACES_ONLY && result.t_world < INFINITE) { met.side = HALF_OPAQUE; }
    let t_world = select(0.0, result.t_world, met.side > 0.0);
    var gradient = field_gradient(locate(line.index.origin + t_world * line.index.direction));
    if (met.clip > 0u) { gradient = face_gradient(met.clip, line.ray.origin_world + t_world * line.ray.direction_world); }
    keep_hit(at, vec4f(gradient, met.value) * f32(met.side > 0.0), vec4f(result.t_world, met.side, 0.0, 0.0));
  }
}

// What is seen of meshes, beside those in front of which the ray has not gone on: in front of a surface that was hit, and behind all.
fn covered(marched: Result, at: u32, first: u32) -> Result {
  if (!HAS_COVERS) { return marched; }
  var number = first;
  var seen = marched;
  if (SURFACES_ONLY) {
    seen = Result(vec3f(0.0), 0.0, INFINITE);
    loop {
      let cover = cover_at(at, number);
      if (cover.t_world >= marched.t_world) { break; }
      seen = result_over(seen, Result(cover.rgb, cover.alpha, cover.t_world));
      number++;
    }
    seen = result_over(seen, marched);
  }
  loop {
    let cover = cover_at(at, number);
    if (cover.t_world >= INFINITE) { break; }
    seen = result_over(seen, Result(cover.rgb, cover.alpha, cover.t_world));
    number++;
  }
  let last = cover_at(at, 0u);
  return result_over(seen, Result(last.rgb, last.alpha, last.t_world));
}

// The surface that is hit: its value; its side, 1 on the way up, 2 on the way down, 3 where what clips keep begins inside; and the
// number of the clip that cuts there, 0 where none does.
struct Met { value: f32, side: f32, clip: u32 }

fn march(line: Line, at: u32, samples: ptr<function, f32>, met: ptr<function, Met>) -> Result {
  var acc = begin();
  var piece = line;
  var leave = line.leave;
  if (HAS_COVERS) { leave = min(leave, cover_at(at, 0u).t_world); }
  var covers_taken = 1u;
  var kept = kept_from(line.ray, line.enter, leave);
  var face = face_at(line, kept);
  piece.enter = kept.begin;
  loop {
    piece.leave = kept.end;
    if (CUTS_AT_COVERS) {
      // Slabs end at meshes that let light pass.
      var cover = cover_at(at, covers_taken);
      loop {
        if (cover.t_world > piece.enter || piece.enter >= leave) { break; }
        take_cover(&acc, cover);
        covers_taken++;
        cover = cover_at(at, covers_taken);
      }
      piece.leave = min(kept.end, cover.t_world);
    }
    if (piece.leave <= piece.enter || march_piece(piece, kept, face, &acc, samples, met)) { break; }
    piece.enter = piece.leave;
    if (HAS_CLIPS && piece.enter >= kept.end) {
      kept = kept_from(line.ray, kept.end, leave);
      face = face_at(line, kept);
      piece.enter = kept.begin;
    }
  }
  return covered(finish(acc), at, covers_taken);
}

// A mesh that lets light pass is a slab without length.
fn take_cover(acc: ptr<function, Accumulated>, cover: Cover) {
  var here: Sample;
  here.t_world = cover.t_world;
  take(acc, here, here, Slab(cover.rgb, 0.0, vec3f(0.0), 0.0, cover.alpha), cover.rgb, 0.0);
}

// The face of the clip at which what is kept begins.
fn face_at(line: Line, kept: Kept) -> Face {
  if (!LIGHTS_FACES) { return Face(); }
  return face_of(kept.near, sample_of(line, fetch(line, kept.begin)), line.ray);
}

// The solid face of a clip, as a slab without length. Whether the ray ends there.
fn take_cap(acc: ptr<function, Accumulated>, cut: Sample, clip: u32, ray: Ray) -> bool {
  let cap = cap_of(clip, cut);
  return cap.alpha > 0.0 && take(acc, cut, cut, cap, lit_cap(cap, clip, cut, ray), 0.0);
}

// Slabs of a piece of a ray, all of it or a part of what clips keep. Whether the ray ends there.
fn march_piece(
  line: Line, kept: Kept, face: Face, acc: ptr<function, Accumulated>, samples: ptr<function, f32>, met: ptr<function, Met>,
) -> bool {
  var walk = begin_walk(line);
  if (DRAWS_CAPS && line.enter <= kept.begin && take_cap(acc, sample_of(line, walk.front), kept.near, line.ray)) { return true; }
  // What is known of a sample is kept: the back of a slab is the front of the next.
  var front_known: Known;
  if (CLASSIFIES) { front_known = know(sample_of(line, walk.front)); }
  var front_light: LitEnd;
  var front_is_lit = false;
  var ended = false;
  var stops = false;
  loop {
    walk_on(&walk, line);
    var front = sample_of(line, walk.front);
    let next = sample_of(line, walk.next);
    if (CLASSIFIES && SKIPS_EMPTY && walk.idled) { front_known = know_empty(front); }
    if (CLASSIFIES && walk.hid) { front_known = know(front); }
    front_is_lit = front_is_lit && !walk.idled && !walk.hid;
    var back = next;
    var length = max(next.t_world - front.t_world, 0.0);
    if (HAS_EMPTY) {
      // Where one end is empty, half of the slab is there, with the sample of the other end.
      let gaps = vec2<bool>(is_gap(front.value), is_gap(next.value));
      if (all(gaps)) {
        ended = next.t_world >= line.leave;
        if (ended) { break; }
        walk.front = walk.next;
        front_is_lit = false;
        continue;
      }
      front_is_lit = front_is_lit && !any(gaps);
      length *= select(1.0, 0.5, any(gaps));
      back = select_sample(next, front, gaps.y);
      front = select_sample(front, next, gaps.x);
      if (CLASSIFIES) { front_known = know(front); }
    }
    let shown = shown_surface(front, back);
    if (shown.x <= 1.0) {
      *met = take_surface(acc, line, front, back, shown, kept, face);
      ended = true;
      stops = true;
      break;
    }
    var slab = NO_SLAB;
    var lit_rgb = vec3f(0.0);
    if (CLASSIFIES) {
      let back_known = know(back);
      // Extinction times opacity is a length times opacity.
      let part = part_at(mix(front.p_index, back.p_index, 0.5));
      let thinning = part.opacity * weight(front, back, length);
      if (HAS_CROSSINGS) {
        // Surfaces cut the slab, the nearest first: the piece before one, then the surface. What is left is a slab as ever.
        // They are told by what the field has at the ends, also where values are put right for curvature; none in a gap.
        // Where the field turns between them it is met twice: there the slab has two legs.
        let ends = ends_of(walk);
        var leg = sample_of(line, ends.front);
        let last = sample_of(line, ends.back);
        let is_cut = !HAS_EMPTY || !(is_gap(leg.value) || is_gap(last.value));
        var goal = select_sample(leg, last, is_cut);
        let turn = turn_of(scalar_of(leg.value), scalar_of(last.value), scalar_of(front.value), scalar_of(back.value));
        var turns = is_cut && turn > 0.0 && turn < 1.0;
        loop {
          if (!turns) { break; }
          // Where nothing was moved past a surface, slabs may have been passed over: then never.
          turns = next_crossing(leg, front, 0u).share <= 1.0 || next_crossing(last, back, 0u).share <= 1.0;
          if (turns) { goal = sample_of(line, fetch(line, mix(leg.t_world, last.t_world, turn))); }
          break;
        }
        var near = leg;
        var passed = 0u;
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
          length = max(hit.t_world - front.t_world, 0.0);
          slab = tinted(classify_known(front, front_known, hit, know_crossing(sheet, hit, false), length * thinning), part.rgb);
          lit_rgb = lit_slab(front, hit, slab, line.ray, &front_light, &front_is_lit);
          if (LIGHTS_FACES) { lit_rgb = lit_behind(face, slab, front, hit, lit_rgb); }
          ended = take(acc, front, hit, slab, lit_rgb, length);
          let alpha = 1.0 - thicker(1.0 - sheet.alpha, thinning);
          slab = Slab(alpha * sheet.rgb * part.rgb, alpha, vec3f(0.0), 0.0, alpha);
          lit_rgb = lit_hit(hit, slab, line.ray, &front_light);
          front_is_lit = true;
          ended = ended || take(acc, hit, hit, slab, lit_rgb, 0.0);
          stops = ended;
          if (ended) { break; }
          front = hit;
          near = hit;
          front_known = know_crossing(sheet, hit, true);
          length = max(back.t_world - front.t_world, 0.0);
          passed++;
        }
        if (ended) { break; }
      }
      slab = tinted(classify_known(front, front_known, back, back_known, length * thinning), part.rgb);
      front_known = back_known;
      lit_rgb = lit_slab(front, back, slab, line.ray, &front_light, &front_is_lit);
      if (LIGHTS_FACES) { lit_rgb = lit_behind(face, slab, front, back, lit_rgb); }
    }
    stops = take(acc, front, back, slab, lit_rgb, length);
    ended = stops || next.t_world >= line.leave;
    if (ended) { break; }
    walk.front = walk.next;
  }
  *samples += walk.samples;
  // A driver may end a loop after a number of turns of its own: the host must know.
  if (!ended) { *samples = -*samples; }
  if (DRAWS_CAPS && ended && !stops && line.leave >= kept.end) {
    stops = take_cap(acc, sample_of(line, fetch(line, line.leave)), kept.far, line.ray);
  }
  return stops || !ended;
}

// The surface within a slab, where at least half of its region is drawn: opacity runs straight from end to end. The share at which
// it lies, and 1 where the field passes its value there, not the border of a region.
fn shown_surface(front: Sample, back: Sample) -> vec2f {
  let share = surface(front, back);
  if (share > 1.0) { return vec2f(share, 0.0); }
  let opacity = vec2f(part_at(front.p_index).opacity, part_at(back.p_index).opacity);
  if (mix(opacity.x, opacity.y, share) >= 0.5) { return vec2f(share, 1.0); }
  if (opacity.y < 0.5) { return vec2f(2.0, 0.0); }
  let begin = (0.5 - opacity.x) / (opacity.y - opacity.x);
  var here = front;
  here.value = mix_values(front.value, back.value, begin);
  return vec2f(select(2.0, begin, surface(here, back) <= 0.0), 0.0);
}

fn select_sample(one: Sample, other: Sample, takes_other: bool) -> Sample {
  if (takes_other) { return other; }
  return one;
}

const NO_SLAB = Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);

// A surface inside a slab: the sample there, as a slab without length.
fn take_surface(
  acc: ptr<function, Accumulated>, line: Line, front: Sample, back: Sample, shown: vec2f, kept: Kept, face: Face,
) -> Met {
  let share = shown.x;
  var t_world = mix(front.t_world, back.t_world, share);
  // What a ray begins in, and what a region's border uncovers, lies where it lies.
  let refines = REFINE > 0u && share > 0.0 && shown.y > 0.0;
  if (refines) {
    let near = vec2f(front.t_world, scalar_of(front.value));
    let far = vec2f(back.t_world, scalar_of(back.value));
    t_world = refined(line.index.origin, line.index.direction, near, far, level(front, back));
  }
  var hit = sample_of(line, fetch(line, t_world));
  if (refines) {
    hit.value = with_scalar(hit.value, level(front, back));
  } else {
    hit.value = mix_values(front.value, back.value, share);
  }
  var rgb = medium(hit).rgb;
  if (share > 0.0) { rgb = surface_rgb(hit, front, back, rgb); }
  rgb *= part_at(hit.p_index).rgb;
  let slab = Slab(rgb, 1.0, vec3f(0.0), 0.0, 1.0);
  var light: LitEnd;
  var lit_rgb = lit_hit(hit, slab, line.ray, &light);
  if (LIGHTS_FACES) { lit_rgb = lit_behind(face, slab, hit, hit, lit_rgb); }
  take(acc, hit, hit, slab, lit_rgb, 0.0);
  let side = select(2.0, 1.0, scalar_of(back.value) > scalar_of(front.value));
  let is_cut = share <= 0.0 && t_world <= kept.begin;
  return Met(scalar_of(hit.value), select(side, 3.0, share <= 0.0), select(0u, kept.near, is_cut));
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

// Light of a slab. How its ends are lit is kept where lighting asks for it: the back is the front of the next.
fn lit_slab(
  front: Sample, back: Sample, slab: Slab, ray: Ray, front_light: ptr<function, LitEnd>, front_is_lit: ptr<function, bool>,
) -> vec3f {
  let shines = slab.alpha > 0.0 || any(slab.front_rgb + slab.back_rgb > vec3f(0.0));
  var lit_rgb = vec3f(0.0);
  if (shines && !LIGHTS_ENDS) { lit_rgb = light_slab(front, back, slab, ray); }
  if (shines && LIGHTS_ENDS) {
    // The front, where it is not known how it is lit, then the back: a loop, since wide processors run both sides of an `if`.
    var end = select_sample(front, back, *front_is_lit);
    var end_light: LitEnd;
    loop {
      end_light = know_light(end, ray);
      if (*front_is_lit) { break; }
      *front_light = end_light;
      *front_is_lit = true;
      end = back;
    }
    lit_rgb = light_known(front, *front_light, back, end_light, slab, ray);
    *front_light = end_light;
  }
  *front_is_lit = shines;
  return lit_rgb;
}

fn lit_hit(hit: Sample, slab: Slab, ray: Ray, light: ptr<function, LitEnd>) -> vec3f {
  if (!LIGHTS_ENDS) { return light_slab(hit, hit, slab, ray); }
  *light = know_light(hit, ray);
  return light_known(hit, *light, hit, *light, slab, ray);
}
