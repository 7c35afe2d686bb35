// The ray march: one ray a pixel, piece by piece, slab by slab from the eye. There is no other march loop.

import generated::frame::frame;
import generated::pass::{radiance, depth};
import generated::sizes::{CLASSIFIES, CUTS_AT_COVERS, DRAWS_CAPS, HAS_CROSSINGS, HAS_EMPTY, LIGHTS_FACES, SKIPS_EMPTY, SURFACES_ONLY};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::faces::{Face, face_gradient, face_of, take_cap};
import package::front::{Front, next_slab};
import package::kept::Kept;
import package::met::Met;
import package::pieces::{covered, end_of, next_kept, take_covers};
import package::places::place_in_tile;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import package::walk::{Line, border_behind, fetch, holds_layer, line_of, sample_of};
import slot::camera::eye_ray;
import slot::clips::HAS_CLIPS;
import slot::crossings::take_crossings;
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::hits::{KEEPS_HITS, keep_hit};
import slot::met::{shown_surface, take_surface};
import slot::transfer::{know, know_empty};
import slot::modulation::weight;
import slot::pixels::pixel_at;
import slot::region::part_at;
import slot::integrate::{Accumulated, begin, take, finish};
import slot::tone::tone;
import slot::values::is_gap;
import slot::walk::{ends_of, begin_walk, walk_on};

const HALF_OPAQUE = 4.0;  // the side of what is kept where no surfaces are looked for

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
  let place = place_in_tile(group.xy, thread);
  if (any(place >= frame.tile_size_px)) { return; }
  let pixel = pixel_at(place);
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

fn march(line: Line, at: u32, samples: ptr<function, f32>, met: ptr<function, Met>) -> Result {
  var acc = begin();
  let leave = end_of(line, at);
  var kept = next_kept(line, line.enter, leave);
  var piece = line;
  piece.enter = kept.begin;
  var face: Face;
  var covers_taken = 1u;
  loop {
    piece.leave = min(kept.end, border_behind(line, piece.enter));
    if (CUTS_AT_COVERS) { piece.leave = min(piece.leave, take_covers(&acc, at, &covers_taken, piece.enter, leave)); }
    if (piece.leave <= piece.enter || (holds_layer(piece) && march_piece(piece, kept, &face, &acc, samples, met))) { break; }
    piece.enter = piece.leave;
    if (HAS_CLIPS && piece.enter >= kept.end) {
      kept = next_kept(line, kept.end, leave);
      piece.enter = kept.begin;
    }
    // Told here, since wide processors would run a last turn for nobody.
    if (piece.enter >= kept.end) { break; }
  }
  return covered(finish(acc), at, covers_taken);
}

// Slabs of a piece of a ray, all of it or a part of what clips keep. Whether the ray ends there.
fn march_piece(
  line: Line, kept: Kept, face: ptr<function, Face>, acc: ptr<function, Accumulated>, samples: ptr<function, f32>, met: ptr<function, Met>,
) -> bool {
  var walk = begin_walk(line);
  let first = sample_of(line, walk.front);
  let begins_at_cut = line.enter <= kept.begin;
  if (LIGHTS_FACES && begins_at_cut) { *face = face_of(kept.near, first, line.ray); }
  if (DRAWS_CAPS && begins_at_cut && take_cap(acc, first, kept.near, line.ray)) {
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
    if (CLASSIFIES && walk.hid) { front.known = know(front.here); }
    front.is_lit = front.is_lit && !walk.idled && !walk.hid;
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
      let thinning = part.opacity * weight(front.here, back, length);
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
  return stops || !ended;
}
