// The front surface at a value: opaque and lit.

import generated::frame::frame;
import generated::first_hit::{params, colours, colours_sampler, COLOUR_BY, SIDE};
import package::gradient::curvature::curvatures;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::lookup::table_at;
import slot::values::scalar_of;

struct Accumulated { rgb: vec3f, t_world: f32 }

fn begin() -> Accumulated { return Accumulated(vec3f(0.0), INFINITE); }

const ABOVE = 0u;
const BOTH = 2u;
const LEAST_SHARE = 1e-7;  // a sheet that is passed is none in which a ray begins

// A ray that begins inside what is solid meets the surface where it begins; a sheet has no inside.
fn surface(front: Sample, back: Sample) -> f32 {
  let s_front = scalar_of(front.value);
  let s_back = scalar_of(back.value);
  let front_above = s_front >= params.iso;
  if (SIDE != BOTH && front_above == (SIDE == ABOVE)) { return 0.0; }
  if (front_above == (s_back >= params.iso)) { return 2.0; }
  return max((params.iso - s_front) / (s_back - s_front), LEAST_SHARE);
}

fn level(front: Sample, back: Sample) -> f32 { return params.iso; }

const MEAN_CURVATURE = 1u;
const GAUSSIAN_CURVATURE = 2u;
const GREATEST_CURVATURE = 3u;
const DISTANCE = 5u;

// Surfaces of the function have a colour for each side, unless it is what they are like that is shown.
fn surface_rgb(hit: Sample, front: Sample, back: Sample, rgb: vec3f) -> vec3f {
  if (COLOUR_BY > 0u) {
    let entries = f32(textureDimensions(colours).x);
    let place = saturate((shown_number(hit) - params.low) * params.per_number);
    return table_at(colours, colours_sampler, vec3f((place * (entries - 1.0) + 0.5) / entries, 0.5, 0.5)).rgb;
  }
  let side_rgb = select(params.back_rgb, params.front_rgb, scalar_of(back.value) > scalar_of(front.value));
  return select(side_rgb, rgb, params.coloured == 0u);
}

fn shown_number(hit: Sample) -> f32 {
  if (COLOUR_BY == DISTANCE) {
    let way = params.world_from_index * (hit.p_index - params.point_index);
    let from_point = select(dot(way, params.normal), length(way), all(params.normal == vec3f(0.0)));
    return select(from_point, hit.t_world + frame.t_offset_world, params.from_eye > 0u);
  }
  let bends = curvatures(hit.p_index);
  if (COLOUR_BY == MEAN_CURVATURE) { return 0.5 * (bends.x + bends.y); }
  if (COLOUR_BY == GAUSSIAN_CURVATURE) { return bends.x * bends.y; }
  return select(bends.y, bends.x, COLOUR_BY == GREATEST_CURVATURE);
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  if (slab.alpha <= 0.0) { return false; }
  (*acc).rgb = lit_rgb;
  (*acc).t_world = front.t_world;
  return true;
}

fn join(front: Accumulated, back: Accumulated) -> Accumulated {
  if (front.t_world < INFINITE) { return front; }
  return back;
}

fn finish(acc: Accumulated) -> Result { return Result(acc.rgb, select(0.0, 1.0, acc.t_world < INFINITE), acc.t_world); }
