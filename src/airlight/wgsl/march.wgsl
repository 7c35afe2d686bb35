// The ray march: one ray a pixel, slab by slab from the eye. There is no other march loop.

import generated::frame::frame;
import generated::layer::layer;
import generated::driver::OFFSETS;
import generated::pass::{radiance, depth};
import generated::sizes::{CLASSIFIES, CURVED, HAS_EMPTY, SKIPS_EMPTY, SURFACES_ONLY, WORKGROUP_X, WORKGROUP_Y};
import package::curved::curved_value;
import package::ray::{Ray, INFINITE};
import package::optics::tinted;
import package::sample::{Sample, Slab, Result};
import slot::camera::eye_ray;
import slot::field::{locate, field_value};
import slot::transfer::{medium, empty_slab, Known, know, know_empty, classify_known};
import slot::lighting::light_slab;
import slot::modulation::weight;
import slot::region::{part_at, hidden_at};
import slot::integrate::{Accumulated, begin, take, finish, surface};
import slot::tone::tone;
import slot::values::{is_gap, mix_values};

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= frame.tile_size_px)) { return; }
  let pixel = frame.tile_origin_px + id.xy;
  let p_px = vec2f(pixel) + 0.5;
  var samples = 0.0;
  let result = march(eye_ray(p_px), offset_of(pixel), &samples);
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  radiance[at] = vec4f(tone(result.rgb, p_px), result.alpha);
  depth[at] = vec2f(result.t_world + frame.t_offset_world, samples);
}

fn march(ray: Ray, offset: f32, samples: ptr<function, f32>) -> Result {
  let index_ray = ray_in_index(ray);
  let span = domain_span(index_ray);
  if (span.y <= span.x) { return Result(vec3f(0.0), 0.0, INFINITE); }
  let h = frame.step_world;
  var acc = begin();
  var front = fetch(ray, index_ray, span.x);
  // What is known of a sample is kept: the back of a slab is the front of the next.
  var front_known: Known;
  if (CLASSIFIES) { front_known = know(front); }
  var k = floor(span.x / h - offset) + 1.0;
  *samples = 1.0;
  // Where values are put right for curvature: the last sample as it was, and the one ahead.
  var before = front;
  var ahead: Sample;
  if (CURVED) { ahead = fetch(ray, index_ray, min((k + offset) * h, span.y)); }
  var ended = false;
  loop {
    // Walk on to the next slab that matters. A loop of its own: wide processors run the rest for all rays at once.
    var next: Sample;
    var walks = false;
    var passes_hidden = false;
    loop {
      loop {
        if (CURVED) {
          next = ahead;
          ahead = fetch(ray, index_ray, min((k + 1.0 + offset) * h, span.y));
          let value = curved_value(before, next, ahead);
          before = next;
          next.value = value;
        } else {
          next = fetch(ray, index_ray, min((k + offset) * h, span.y));
        }
        *samples += 1.0;
        k += 1.0;
        if (next.t_world >= span.y || !is_idle(front, next)) { break; }
        front = next;
        walks = true;
        passes_hidden = false;
      }
      if (next.t_world >= span.y || !SKIPS_EMPTY || !hidden_at(mix(front.p_index, next.p_index, 0.5))) { break; }
      front = next;
      passes_hidden = true;
    }
    if (CLASSIFIES && SKIPS_EMPTY && walks) { front_known = know_empty(front); }
    if (CLASSIFIES && passes_hidden) { front_known = know(front); }
    var back = next;
    var length = max(next.t_world - front.t_world, 0.0);
    if (HAS_EMPTY) {
      // Where one end is empty, half of the slab is there, with the sample of the other end.
      let gaps = vec2<bool>(is_gap(front.value), is_gap(next.value));
      if (all(gaps)) {
        ended = next.t_world >= span.y;
        if (ended) { break; }
        front = next;
        continue;
      }
      length *= select(1.0, 0.5, any(gaps));
      back = select_sample(next, front, gaps.y);
      front = select_sample(front, next, gaps.x);
      if (CLASSIFIES) { front_known = know(front); }
    }
    let share = shown_surface(front, back);
    if (share <= 1.0) {
      take_surface(&acc, ray, index_ray, front, back, share);
      ended = true;
      break;
    }
    var slab = NO_SLAB;
    var lit_rgb = vec3f(0.0);
    if (CLASSIFIES) {
      let back_known = know(back);
      // Extinction times opacity is a length times opacity.
      let part = part_at(mix(front.p_index, back.p_index, 0.5));
      let thinned = length * part.opacity * weight(front, back, length);
      slab = tinted(classify_known(front, front_known, back, back_known, thinned), part.rgb);
      front_known = back_known;
      if (slab.alpha > 0.0 || any(slab.front_rgb + slab.back_rgb > vec3f(0.0))) {
        lit_rgb = light_slab(front, back, slab, ray);
      }
    }
    ended = take(&acc, front, back, slab, lit_rgb, length) || next.t_world >= span.y;
    if (ended) { break; }
    front = next;
  }
  // A driver may end a loop after a number of turns of its own: the host must know.
  if (!ended) { *samples = -*samples; }
  return finish(acc);
}

// Whether a slab leaves the result as it is, told from its two samples alone.
fn is_idle(front: Sample, next: Sample) -> bool {
  if (SURFACES_ONLY) { return surface(front, next) > 1.0; }
  return SKIPS_EMPTY && empty_slab(front, next);
}

// The surface within a slab, where at least half of its region is drawn: opacity runs straight from end to end.
fn shown_surface(front: Sample, back: Sample) -> f32 {
  let share = surface(front, back);
  if (share > 1.0) { return share; }
  let opacity = vec2f(part_at(front.p_index).opacity, part_at(back.p_index).opacity);
  if (mix(opacity.x, opacity.y, share) >= 0.5) { return share; }
  if (opacity.y < 0.5) { return 2.0; }
  let begin = (0.5 - opacity.x) / (opacity.y - opacity.x);
  var here = front;
  here.value = mix_values(front.value, back.value, begin);
  return select(2.0, begin, surface(here, back) <= 0.0);
}

fn select_sample(one: Sample, other: Sample, takes_other: bool) -> Sample {
  if (takes_other) { return other; }
  return one;
}

const NO_SLAB = Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);

// A surface inside a slab: the sample there, as a slab without length.
fn take_surface(
  acc: ptr<function, Accumulated>, ray: Ray, index_ray: IndexRay, front: Sample, back: Sample, share: f32,
) {
  var hit = fetch(ray, index_ray, mix(front.t_world, back.t_world, share));
  hit.value = mix_values(front.value, back.value, share);
  let rgb = medium(hit).rgb * part_at(hit.p_index).rgb;
  let slab = Slab(rgb, 1.0, vec3f(0.0), 0.0, 1.0);
  take(acc, hit, hit, slab, light_slab(hit, hit, slab, ray), 0.0);
}

// The same ray in index coordinates, still measured in world units.
struct IndexRay { origin_index: vec3f, direction_index: vec3f }

fn ray_in_index(ray: Ray) -> IndexRay {
  return IndexRay(
    (layer.index_from_world * vec4f(ray.origin_world, 1.0)).xyz,
    (layer.index_from_world * vec4f(ray.direction_world, 0.0)).xyz,
  );
}

fn fetch(ray: Ray, index_ray: IndexRay, t_world: f32) -> Sample {
  let p_world = ray.origin_world + t_world * ray.direction_world;
  let p_index = index_ray.origin_index + t_world * index_ray.direction_index;
  return Sample(field_value(locate(p_index)), vec3f(0.0), p_index, p_world, t_world);
}

// Where the ray enters and leaves the domain, not before the eye [world].
fn domain_span(ray: IndexRay) -> vec2f {
  let origin = ray.origin_index;
  let direction = ray.direction_index;
  // A ray along a face has no direction across it: it is outside, or it is held by the other faces.
  let across = abs(direction) <= vec3f(1e-7 * max(abs(direction.x), max(abs(direction.y), abs(direction.z))));
  let outside = across & ((origin < layer.domain_low) | (origin > layer.domain_high));
  if (any(outside)) { return vec2f(0.0); }
  let rate = select(direction, vec3f(1.0), across);
  let a = select((layer.domain_low - origin) / rate, vec3f(-INFINITE), across);
  let b = select((layer.domain_high - origin) / rate, vec3f(INFINITE), across);
  let near = min(a, b);
  let far = max(a, b);
  return vec2f(max(max(near.x, near.y), max(near.z, 0.0)), min(far.x, min(far.y, far.z)));
}

// Shift of the lattice of samples, as a share of a step: sixteen of them over squares of 4 x 4 pixels (Scharsach, section 5).
fn offset_of(pixel: vec2u) -> f32 {
  if (OFFSETS == 0u) { return 0.0; }
  let fine = pixel & vec2u(1u);
  let coarse = (pixel >> vec2u(1u)) & vec2u(1u);
  let rank = 4u * (2u * (fine.x ^ fine.y) + fine.y) + 2u * (coarse.x ^ coarse.y) + coarse.y;
  return f32(rank) / 16.0;
}
