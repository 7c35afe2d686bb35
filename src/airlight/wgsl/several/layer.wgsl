// A layer of several, and those behind it in the list. What is asked of all goes from one to the next; `layer_end.wgsl` ends it.
//
// Of a ray each layer knows the part in its own domain. Samples of all layers lie at the same distances, held to that part: a slab
// that lies before or behind it has no length for the layer. Slabs are cut where a layer begins or ends, and where a clip cuts it
// alone: of a piece of the ray in between, the part is what its own clips keep.

import generated::layer::layer;
import generated::sizes::{CUTS_LAYERS, HAS_EMPTY};
import next::several::layer::{Faces as RestFaces, Fetches as RestFetches, Knowns as RestKnowns, Lights as RestLights, Lines as RestLines};
import next::several::layer::{are_hidden as rest_are_hidden, are_idle as rest_are_idle, block_behind as rest_block_behind};
import next::several::layer::{border_of as rest_border_of, caps_of as rest_caps_of, curve as rest_curve, cuts_of as rest_cuts_of};
import next::several::layer::{fetch_all as rest_fetch_all, hold_part as rest_hold_part, know_all as rest_know_all};
import next::several::layer::{last_border_of as rest_last_border_of};
import next::several::layer::{know_all_empty as rest_know_all_empty, lines_of as rest_lines_of, send as rest_send, span_of as rest_span_of};
import next::several::layer::{own_caps_of as rest_own_caps_of, own_cuts_of as rest_own_cuts_of, parts_at as rest_parts_at};
import package::curved::curved_value;
import package::faces::{Face, cap_of, face_of, lit_cap};
import package::front::{Front, next_slab};
import package::kept::Kept;
import package::ray::{Ray, INFINITE};
import package::sample::Sample;
import package::several::ends::{filled_ends, sample_here};
import package::several::mixing::{Caps, Mixed, depth_per_alpha};
import package::walk::{Fetched, Line, fetch, is_hidden, is_idle, line_of, next_block};
import slot::clips::kept_by;
import slot::lighting::LitEnd;
import slot::modulation::weight;
import slot::region::part_at;
import slot::transfer::{Known, know, know_empty};

// By number the clips, counted from 1, that cut the layer alone where its part begins and ends.
struct Lines { own: Line, near: u32, far: u32, rest: RestLines }

// Values at one distance, each with its own, held to the layer's part of the ray.
struct Fetches { own: Fetched, rest: RestFetches }

// What is known of the samples at one distance, and how they are lit, where that is known.
struct Knowns { own: Known, rest: RestKnowns }
struct Lights { own: LitEnd, is_lit: bool, rest: RestLights }

struct Faces { own: Face, rest: RestFaces }

// A slab of all layers, and what is known of its back.
struct Sent { mixed: Mixed, knowns: Knowns, lights: Lights }

fn lines_of(ray: Ray, pixel: vec2u) -> Lines {
  var line = line_of(ray, pixel);
  if (line.leave <= line.enter) {
    line.enter = 0.0;
    line.leave = 0.0;
  }
  return Lines(line, 0u, 0u, rest_lines_of(ray, pixel));
}

// From where the first layer begins to where the last one ends.
fn span_of(lines: Lines) -> vec2f {
  let rest = rest_span_of(lines.rest);
  let both = vec2f(min(lines.own.enter, rest.x), max(lines.own.leave, rest.y));
  return select(rest, both, lines.own.enter < lines.own.leave);
}

// The next distance at which a layer begins or ends.
fn border_of(lines: Lines, t_world: f32) -> f32 {
  let line = lines.own;
  var end = line.leave;
  if (CUTS_LAYERS) {
    let kept = kept_by(layer.first_clip, line.ray, line.at, t_world, line.leave);
    end = min(end, select(kept.end, kept.begin, kept.begin > t_world));
  }
  end = select(INFINITE, end, line.leave > t_world);
  return min(select(end, line.enter, line.enter > t_world), rest_border_of(lines.rest, t_world));
}

// The parts of all layers that hold a distance, as their own clips keep them.
fn parts_at(lines: Lines, t_world: f32) -> Lines {
  var line = lines.own;
  var kept = Kept(line.enter, line.enter, 0u, 0u);
  loop {
    kept = kept_by(layer.first_clip, line.ray, line.at, kept.end, line.leave);
    if (kept.end > t_world || kept.begin >= kept.end) { break; }
  }
  let is_held = kept.begin < t_world && t_world < kept.end;
  if (!is_held) { kept = Kept(0.0, 0.0, 0u, 0u); }
  line.enter = kept.begin;
  line.leave = kept.end;
  return Lines(line, kept.near, kept.far, rest_parts_at(lines.rest, t_world));
}

// The last one that is not behind another.
fn last_border_of(lines: Lines, t_world: f32) -> f32 {
  let line = lines.own;
  let begin = select(0.0, line.enter, line.enter <= t_world);
  return max(select(begin, line.leave, line.leave <= t_world), rest_last_border_of(lines.rest, t_world));
}

// Whether some layer holds a distance.
fn hold_part(lines: Lines, t_world: f32) -> bool {
  return (lines.own.enter < t_world && t_world < lines.own.leave) || rest_hold_part(lines.rest, t_world);
}

// The next distance at which a layer meets a block in which there may be something to be seen.
fn block_behind(lines: Lines, t_world: f32, t_leave: f32) -> f32 {
  let line = lines.own;
  let end = min(line.leave, t_leave);
  var begin = INFINITE;
  if (t_world < end) {
    begin = next_block(line, max(t_world, line.enter), end);
    if (begin >= end) { begin = INFINITE; }
  }
  return min(begin, rest_block_behind(lines.rest, t_world, t_leave));
}

fn fetch_all(lines: Lines, t_world: f32) -> Fetches {
  let held = clamp(t_world, lines.own.enter, lines.own.leave);
  return Fetches(fetch(lines.own, held), rest_fetch_all(lines.rest, t_world));
}

fn curve(before: Fetches, here: Fetches, after: Fetches) -> Fetches {
  let own = Fetched(curved_value(before.own, here.own, after.own), here.own.t_world);
  return Fetches(own, rest_curve(before.rest, here.rest, after.rest));
}

fn is_beside(line: Line, front: Fetched, next: Fetched) -> bool {
  return front.t_world >= line.leave || next.t_world <= line.enter;
}

fn are_idle(lines: Lines, front: Fetches, next: Fetches) -> bool {
  let own = is_beside(lines.own, front.own, next.own) || is_idle(lines.own, front.own, next.own);
  return own && rest_are_idle(lines.rest, front.rest, next.rest);
}

fn are_hidden(lines: Lines, front: Fetches, next: Fetches) -> bool {
  let own = is_beside(lines.own, front.own, next.own) || is_hidden(lines.own, front.own, next.own);
  return own && rest_are_hidden(lines.rest, front.rest, next.rest);
}

fn know_all(values: Fetches, p_world: vec3f) -> Knowns {
  return Knowns(know(sample_here(values.own, p_world)), rest_know_all(values.rest, p_world));
}

fn know_all_empty(values: Fetches, p_world: vec3f) -> Knowns {
  return Knowns(know_empty(sample_here(values.own, p_world)), rest_know_all_empty(values.rest, p_world));
}

// The slabs of all layers between two places of a ray, each lit by itself, as one. By `share` extinction is multiplied.
fn send(
  knowns: Knowns, lights: Lights, is_lit: bool, near: Fetches, p_near: vec3f, far: Fetches, p_far: vec3f, share: f32, faces: Faces,
  ray: Ray,
) -> Sent {
  let ends = filled_ends(sample_here(near.own, p_near), sample_here(far.own, p_far));
  let length = max(far.own.t_world - near.own.t_world, 0.0) * ends.share;
  var front = Front(ends.front, knowns.own, lights.own, is_lit && lights.is_lit && ends.share == 1.0);
  if (HAS_EMPTY) { front.known = know(ends.front); }
  var source = vec3f(0.0);
  var depth = 0.0;
  if (length > 0.0) {
    let part = part_at(mix(ends.front.p_index, ends.back.p_index, 0.5));
    let thinned = length * part.opacity * weight(ends.front, ends.back, length) * share;
    let sent = next_slab(&front, ends.back, thinned, part.rgb, faces.own, ray);
    let per_alpha = depth_per_alpha(sent.slab.alpha);
    source = sent.lit_rgb * per_alpha;
    depth = sent.slab.alpha * per_alpha;
  }
  let rest = rest_send(knowns.rest, lights.rest, is_lit, near.rest, p_near, far.rest, p_far, share, faces.rest, ray);
  return Sent(
    Mixed(source + rest.mixed.source, depth + rest.mixed.depth),
    Knowns(front.known, rest.knowns),
    Lights(front.light, front.is_lit, rest.lights),
  );
}

// How a cut is lit in the layers that it goes through.
fn cuts_of(number: u32, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Faces {
  var own = face_of(number, sample_here(cut.own, p_world), ray);
  if (cut.own.t_world != t_world) { own.share = 0.0; }
  return Faces(own, rest_cuts_of(number, cut.rest, p_world, t_world, ray));
}

// The solid faces of a cut.
fn caps_of(number: u32, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Caps {
  let rest = rest_caps_of(number, cut.rest, p_world, t_world, ray);
  if (cut.own.t_world != t_world) { return rest; }
  return with_cap(rest, number, sample_here(cut.own, p_world), ray);
}

// The faces of all layers, of which some are cut here by clips of their own.
fn own_cuts_of(faces: Faces, lines: Lines, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Faces {
  var own = faces.own;
  if (lines.near > 0u && lines.own.enter == t_world) { own = face_of(lines.near, sample_here(cut.own, p_world), ray); }
  return Faces(own, rest_own_cuts_of(faces.rest, lines.rest, cut.rest, p_world, t_world, ray));
}

fn own_caps_of(lines: Lines, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Caps {
  let rest = rest_own_caps_of(lines.rest, cut.rest, p_world, t_world, ray);
  let number = select(select(0u, lines.far, lines.own.leave == t_world), lines.near, lines.own.enter == t_world);
  if (number == 0u) { return rest; }
  return with_cap(rest, number, sample_here(cut.own, p_world), ray);
}

fn with_cap(rest: Caps, number: u32, here: Sample, ray: Ray) -> Caps {
  let cap = cap_of(number, here);
  if (cap.alpha <= 0.0) { return rest; }
  return Caps(rest.rgb + lit_cap(cap, number, here, ray), rest.count + 1.0);
}
