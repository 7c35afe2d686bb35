// Surfaces of equal value, from the tables of `transfer/crossings.py`: which of them a slab crosses, and what these send together.

import generated::transfer::{params, pairs};
import package::sample::{Sample, Slab};

// The surfaces between a slab's two ends: values, and places in the slab, of the front-most and the hindmost.
struct Crossing { pair: u32, first_value: f32, last_value: f32, first: f32, last: f32, mean_extinction: f32 }

fn crossing_of(s_front: f32, front: u32, s_back: f32, back: u32) -> Crossing {
  let pair = (front * (params.surface_count + 1u) + back) * params.surface_layers;
  let between = pair_at(pair);
  let span = select(1.0, s_back - s_front, s_back != s_front);
  let places = saturate((between.xy - s_front) / span);
  return Crossing(pair, between.x, between.y, places.x, places.y, between.z);
}

// The number behind so many surfaces.
fn step_on(number: u32, surfaces: u32, rises: bool) -> u32 { return select(number - surfaces, number + surfaces, rises); }

// Lines of 1024 texels, slices of 1024 lines.
fn pair_at(texel: u32) -> vec4f {
  return textureLoad(pairs, vec3u(texel & 1023u, (texel >> 10u) & 1023u, texel >> 20u), 0);
}

// Light of the surfaces, and its moment over the way from the first to the last, as kept for a length.
fn light_at(crossing: Crossing, length: u32) -> vec4f { return pair_at(crossing.pair + 1u + 2u * length); }

fn moment_at(crossing: Crossing, length: u32) -> vec4f { return pair_at(crossing.pair + 2u + 2u * length); }

// As a slab that is lit where the surfaces are.
fn crossed(crossing: Crossing, light: vec4f, moment: vec4f) -> Slab {
  let back = clamp(crossing.first * light + (crossing.last - crossing.first) * moment, vec4f(0.0), light);
  let front = light - back;
  return Slab(front.rgb, front.a, back.rgb, back.a, light.a);
}

// By how much a driver has stretched a slab: its optical thickness, that of surfaces too, is multiplied.
fn thickness_of(front: Sample, back: Sample, length: f32) -> f32 {
  let distance = back.t_world - front.t_world;
  return select(1.0, length / distance, distance > 0.0 && length != distance);
}

// The same light of another opacity.
fn thinned(slab: Slab, alpha: f32) -> Slab {
  let f = alpha / max(slab.alpha, 1e-30);
  return Slab(slab.front_rgb * f, slab.front_specular * f, slab.back_rgb * f, slab.back_specular * f, alpha);
}
