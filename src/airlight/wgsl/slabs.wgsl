// Slabs of a ray, one after the other, as they are classified, lit and taken: there is no other march loop.

import generated::sizes::{CLASSIFIES, CUTS_AT_COVERS, CUTS_LAYERS, DRAWS_CAPS, HAS_CROSSINGS, HAS_EMPTY, HIDES, IN_PARTS, LIGHTS_FACES, SKIPS_EMPTY};
import package::faces::{Face, face_of, own_faces, take_cap, take_own_caps};
import package::front::{Front, next_slab};
import package::kept::Kept;
import package::met::Met;
import package::pieces::{begin_of, end_of, next_kept, take_covers};
import package::sample::Slab;
import package::walk::{Line, border_behind, fetch, hold_layers, sample_of};
import slot::clips::HAS_CLIPS;
import slot::crossings::take_crossings;
import slot::integrate::{Accumulated, take};
import slot::met::{shown_surface, take_surface};
import slot::modulation::weight;
import slot::region::part_at;
import slot::transfer::{know, know_empty};
import slot::values::is_gap;
import slot::walk::{ends_of, begin_walk, walk_on};

// A part of a ray [world], piece by piece as clips keep it. Whether the ray ends there.
fn march_part(
  line: Line, t_begin: f32, t_end: f32, at: u32,
  acc: ptr<function, Accumulated>, covers_taken: ptr<function, u32>, samples: ptr<function, f32>, met: ptr<function, Met>,
) -> bool {
  let leave = end_of(line, at);
  var kept = next_kept(line, line.enter, leave);
  if (IN_PARTS && HAS_CLIPS) {
    loop {
      if (kept.end > t_begin || kept.begin >= kept.end) { break; }
      kept = next_kept(line, kept.end, leave);
    }
  }
  var face: Face;
  var piece = line;
  piece.enter = max(kept.begin, t_begin);
  if (IN_PARTS && LIGHTS_FACES && kept.begin < piece.enter) {
    face = face_of(kept.near, sample_of(line, fetch(line, kept.begin)), line.ray);
  }
  var stops = false;
  var begin = begin_of(line, kept, at, *covers_taken, piece.enter);
  loop {
    piece.begin = begin;
    piece.end = min(kept.end, border_behind(line, piece.enter));
    if (CUTS_AT_COVERS) { piece.end = min(piece.end, take_covers(acc, at, covers_taken, piece.enter, leave)); }
    piece.leave = min(piece.end, t_end);
    if (piece.leave <= piece.enter) { break; }
    stops = hold_layers(&piece, line) && march_piece(piece, kept, &face, acc, samples, met);
    if (stops) { break; }
    piece.enter = piece.leave;
    if (HAS_CLIPS && piece.enter >= kept.end) {
      kept = next_kept(line, kept.end, leave);
      piece.enter = kept.begin;
    }
    begin = piece.enter;
    // Told here, since wide processors would run a last turn for nobody.
    if (piece.enter >= min(kept.end, t_end)) { break; }
  }
  return stops;
}

// Slabs of a piece of a ray, all of it or a part of what clips keep. Whether the ray ends there.
fn march_piece(
  line: Line, kept: Kept, face: ptr<function, Face>, acc: ptr<function, Accumulated>, samples: ptr<function, f32>, met: ptr<function, Met>,
) -> bool {
  var walk = begin_walk(line);
  let first = sample_of(line, walk.front);
  let begins_at_cut = line.enter <= kept.begin;
  if (LIGHTS_FACES && begins_at_cut) { *face = face_of(kept.near, first, line.ray); }
  if (CUTS_LAYERS && LIGHTS_FACES) { *face = own_faces(*face, line, first); }
  var is_capped = DRAWS_CAPS && begins_at_cut && take_cap(acc, first, kept.near, line.ray);
  if (CUTS_LAYERS && DRAWS_CAPS && !is_capped) { is_capped = take_own_caps(acc, line, first); }
  if (DRAWS_CAPS && is_capped) {
    *samples += walk.samples;
    return true;
  }
  var front: Front;
  if (CLASSIFIES) { front.known = know(first); }
  var ended = false;
  var stops = false;
  loop {
    walk_on(&walk, line, acc);
    front.here = sample_of(line, walk.front);
    let next = sample_of(line, walk.next);
    if (CLASSIFIES && SKIPS_EMPTY && walk.idled) { front.known = know_empty(front.here); }
    if (CLASSIFIES && HIDES && walk.hid) { front.known = know(front.here); }
    front.is_lit = front.is_lit && !walk.idled && !(HIDES && walk.hid);
    var back = next;
    var length = max(next.t_world - front.here.t_world, 0.0);
    if (HAS_EMPTY) {
      // Where one end is empty, half of the slab is there, with the sample of the other end.
      let gaps = vec2<bool>(is_gap(front.here.value), is_gap(next.value));
      if (all(gaps)) {
        ended = next.t_world >= line.leave;
        if (ended) { break; }
        walk.front = walk.next;
        front.is_lit = false;
        continue;
      }
      front.is_lit = front.is_lit && !any(gaps);
      length *= select(1.0, 0.5, any(gaps));
      if (gaps.y) { back = front.here; }
      if (gaps.x) { front.here = next; }
      if (CLASSIFIES) { front.known = know(front.here); }
    }
    let shown = shown_surface(front.here, back);
    if (shown.x <= 1.0) {
      *met = take_surface(acc, line, front.here, back, shown, kept, *face);
      ended = true;
      stops = true;
      break;
    }
    var slab = Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);
    var lit_rgb = vec3f(0.0);
    if (CLASSIFIES) {
      // Extinction times opacity is a length times opacity.
      let part = part_at(mix(front.here.p_index, back.p_index, 0.5));
      let thinning = part.opacity * weight(front.here, back, length) * line.spacing.share;
      if (HAS_CROSSINGS) {
        ended = take_crossings(acc, &front, back, &length, ends_of(walk), line, *face, part, thinning);
        stops = ended;
        if (ended) { break; }
      }
      let sent = next_slab(&front, back, length * thinning, part.rgb, *face, line.ray);
      slab = sent.slab;
      lit_rgb = sent.lit_rgb;
    }
    stops = take(acc, front.here, back, slab, lit_rgb, length);
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
  if (CUTS_LAYERS && DRAWS_CAPS && ended && !stops) { stops = take_own_caps(acc, line, sample_of(line, fetch(line, line.leave))); }
  return stops || !ended;
}
