// The ray march: one ray a pixel, slab by slab from the eye. There is no other march loop.

import generated::frame::frame;
import generated::layer::layer;
import generated::driver::{BLOCKS, OFFSETS, REFINE};
import generated::pass::{radiance, depth};
import generated::sizes::{CLASSIFIES, CURVED, HAS_EMPTY, LIGHTS_ENDS, SKIPS_EMPTY, SURFACES_ONLY, WORKGROUP_X, WORKGROUP_Y};
import package::blocks::{PIECES, Way, way_from, step_on};
import package::curved::curved_value;
import package::ray::{Ray, INFINITE};
import package::optics::tinted;
import package::refine::refined;
import package::sample::{Sample, Slab, Result};
import slot::camera::eye_ray;
import slot::field::{locate, field_value};
import slot::gradient::field_gradient;
import slot::hits::{KEEPS_HITS, keep_hit};
import slot::transfer::{medium, empty_slab, Known, know, know_empty, classify_known};
import slot::lighting::{light_slab, LitEnd, know_light, light_known};
import slot::modulation::weight;
import slot::region::{part_at, hidden_at};
import slot::integrate::{Accumulated, begin, take, finish, surface, level, surface_rgb};
import slot::tone::tone;
import slot::blocks::leap_of;
import slot::values::{is_gap, mix_values, scalar_of, with_scalar};

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (any(id.xy >= frame.tile_size_px)) { return; }
  let pixel = frame.tile_origin_px + id.xy;
  let p_px = vec2f(pixel) + 0.5;
  var samples = 0.0;
  var met = vec2f(0.0);
  let ray = eye_ray(p_px);
  let result = march(ray, offset_of(pixel), &samples, &met);
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  radiance[at] = vec4f(tone(result.rgb, p_px), result.alpha);
  depth[at] = vec2f(result.t_world + frame.t_offset_world, samples);
  if (KEEPS_HITS) {
    let index_ray = ray_in_index(ray);
    let t_world = select(0.0, result.t_world, met.y > 0.0);
    let gradient = field_gradient(locate(index_ray.origin_index + t_world * index_ray.direction_index));
    keep_hit(at, vec4f(gradient, met.x) * f32(met.y > 0.0), vec4f(result.t_world, met.y, 0.0, 0.0));
  }
}

// `met` is the value of the surface that is hit, and its side: 1 on the way up, 2 on the way down, 3 where the ray begins inside.
fn march(ray: Ray, offset: f32, samples: ptr<function, f32>, met: ptr<function, vec2f>) -> Result {
  let index_ray = ray_in_index(ray);
  let span = domain_span(index_ray);
  if (span.y <= span.x) { return Result(vec3f(0.0), 0.0, INFINITE); }
  let h = frame.step_world;
  var acc = begin();
  var front = fetch(ray, index_ray, span.x);
  // What is known of a sample is kept: the back of a slab is the front of the next.
  var front_known: Known;
  if (CLASSIFIES) { front_known = know(front); }
  var front_light: LitEnd;
  var front_is_lit = false;
  var k = floor(span.x / h - offset) + 1.0;
  *samples = 1.0;
  // Where values are put right for curvature: the last sample as it was, and the one ahead.
  var before = front;
  var ahead: Sample;
  if (CURVED) { ahead = fetch(ray, index_ray, min((k + offset) * h, span.y)); }
  // Where surfaces are looked for: the block of voxels that the ray is in, and the piece of it that comes next.
  var way: Way;
  var piece = 1.0;
  if (SURFACES_ONLY && BLOCKS) { way = way_from(index_ray.origin_index, index_ray.direction_index, span.x); }
  var ended = false;
  loop {
    // Walk on to the next slab that matters. A loop of its own: wide processors run the rest for all rays at once.
    var next: Sample;
    var walks = false;
    var passes_hidden = false;
    loop {
      // Pass over blocks in which there is no surface.
      var leaves = false;
      if (SURFACES_ONLY && BLOCKS && leap_of(way.block) > 0.0) {
        way = leapt(way, span.y);
        piece = 1.0;
        if (way.begin < span.y) { front = fetch(ray, index_ray, way.begin); }
        k = floor(min(way.begin, span.y) / h - offset) + 1.0;
        *samples += 1.0;
      }
      loop {
        if (CURVED) {
          next = ahead;
          ahead = fetch(ray, index_ray, min((k + 1.0 + offset) * h, span.y));
          let value = curved_value(before, next, ahead);
          before = next;
          next.value = value;
          k += 1.0;
        } else if (SURFACES_ONLY && BLOCKS) {
          // Samples lie on the lattice, where the ray enters and leaves a block, and between.
          let on_lattice = (k + offset) * h;
          let in_block = mix(way.begin, way.end, piece / PIECES);
          next = fetch(ray, index_ray, min(min(on_lattice, in_block), span.y));
          k += f32(on_lattice <= in_block);
          piece += f32(in_block <= on_lattice);
          if (piece > PIECES) {
            way = step_on(way, 1.0);
            piece = 1.0;
            leaves = leap_of(way.block) > 0.0;
          }
        } else {
          next = fetch(ray, index_ray, min((k + offset) * h, span.y));
          k += 1.0;
        }
        *samples += 1.0;
        if (next.t_world >= span.y || !is_idle(front, next) || leaves) { break; }
        front = next;
        walks = true;
        passes_hidden = false;
      }
      if (SURFACES_ONLY && leaves && next.t_world < span.y && is_idle(front, next)) {
        front = next;
        continue;
      }
      if (next.t_world >= span.y || !SKIPS_EMPTY || !hidden_at(mix(front.p_index, next.p_index, 0.5))) { break; }
      front = next;
      passes_hidden = true;
    }
    if (CLASSIFIES && SKIPS_EMPTY && walks) { front_known = know_empty(front); }
    if (CLASSIFIES && passes_hidden) { front_known = know(front); }
    front_is_lit = front_is_lit && !walks && !passes_hidden;
    var back = next;
    var length = max(next.t_world - front.t_world, 0.0);
    if (HAS_EMPTY) {
      // Where one end is empty, half of the slab is there, with the sample of the other end.
      let gaps = vec2<bool>(is_gap(front.value), is_gap(next.value));
      if (all(gaps)) {
        ended = next.t_world >= span.y;
        if (ended) { break; }
        front = next;
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
      *met = take_surface(&acc, ray, index_ray, front, back, shown);
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
      let shines = slab.alpha > 0.0 || any(slab.front_rgb + slab.back_rgb > vec3f(0.0));
      if (shines && !LIGHTS_ENDS) { lit_rgb = light_slab(front, back, slab, ray); }
      if (shines && LIGHTS_ENDS) {
        // The front, where it is not known how it is lit, then the back: a loop, since wide processors run both sides of an `if`.
        var end = select_sample(front, back, front_is_lit);
        var end_light: LitEnd;
        loop {
          end_light = know_light(end, ray);
          if (front_is_lit) { break; }
          front_light = end_light;
          front_is_lit = true;
          end = back;
        }
        lit_rgb = light_known(front, front_light, back, end_light, slab, ray);
        front_light = end_light;
      }
      front_is_lit = shines;
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

// The next block in which there may be a surface.
fn leapt(start: Way, t_leave: f32) -> Way {
  var way = start;
  loop {
    let reach = leap_of(way.block);
    if (reach == 0.0 || way.begin >= t_leave) { break; }
    way = step_on(way, reach);
  }
  return way;
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
  acc: ptr<function, Accumulated>, ray: Ray, index_ray: IndexRay, front: Sample, back: Sample, shown: vec2f,
) -> vec2f {
  let share = shown.x;
  var t_world = mix(front.t_world, back.t_world, share);
  // What a ray begins in, and what a region's border uncovers, lies where it lies.
  let refines = REFINE > 0u && share > 0.0 && shown.y > 0.0;
  if (refines) {
    let near = vec2f(front.t_world, scalar_of(front.value));
    let far = vec2f(back.t_world, scalar_of(back.value));
    t_world = refined(index_ray.origin_index, index_ray.direction_index, near, far, level(front, back));
  }
  var hit = fetch(ray, index_ray, t_world);
  if (refines) {
    hit.value = with_scalar(hit.value, level(front, back));
  } else {
    hit.value = mix_values(front.value, back.value, share);
  }
  var rgb = medium(hit).rgb;
  if (share > 0.0) { rgb = surface_rgb(front, back, rgb); }
  rgb *= part_at(hit.p_index).rgb;
  let slab = Slab(rgb, 1.0, vec3f(0.0), 0.0, 1.0);
  take(acc, hit, hit, slab, lit_hit(hit, slab, ray), 0.0);
  let side = select(2.0, 1.0, scalar_of(back.value) > scalar_of(front.value));
  return vec2f(scalar_of(hit.value), select(side, 3.0, share <= 0.0));
}

fn lit_hit(hit: Sample, slab: Slab, ray: Ray) -> vec3f {
  if (!LIGHTS_ENDS) { return light_slab(hit, hit, slab, ray); }
  let light = know_light(hit, ray);
  return light_known(hit, light, hit, light, slab, ray);
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
