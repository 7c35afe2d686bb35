// A piece of a medium between two values, light attenuated on its way through it.

import generated::transfer::{params, slabs, slabs_sampler, LAYERED, WEIGHTED};
import package::optics::{make_slab, mean_transmittance, moved, split};
import package::sample::Slab;
import package::transfer::cells::Reached;
import package::transfer::straight::{mean_between, lengths_of, with_ends};
import package::transfer::kept::LEAST_MOVE;
import slot::lookup::layer_at;

fn between(s_front: f32, front: Reached, s_back: f32, back: Reached, length: f32) -> Slab {
  let lengths = lengths_of(s_front, front, s_back, back, length);
  return with_ends(front, slab_between(front, back, lengths.y), back, lengths);
}

// The integral says mean source and extinction; the table, over (front, back), by how much attenuation shifts the source, and
// which share of the light lies towards the back.
fn slab_between(front: Reached, back: Reached, length: f32) -> Slab {
  let mean = mean_between(front, back, params.per_value);
  let depth = mean.a * length;
  let entries = f32(params.slab_entries);
  let at = ((vec2f(front.value, back.value) - params.first_value) * (params.per_value * (entries - 1.0)) + 0.5) / entries;
  let shift = kept_at(at, length, 0u).rgb * max(moved(depth), LEAST_MOVE);
  // No slab sends less than nothing, nor more than without attenuation.
  let source = clamp(mean.rgb + shift, vec3f(0.0), mean.rgb / mean_transmittance(depth));
  let slab = make_slab(source, mean.a, length);
  if (!WEIGHTED) { return slab; }
  // In slabs that are shorter than the table's least length attenuation moves light by less.
  let least_depth = mean.a * max(length, params.slab_length / f32(params.slab_lengths));
  return split(slab, saturate(kept_at(at, length, params.slab_lengths) + (moved(least_depth) - moved(depth))));
}

// The table at a length; its layers from `first` on are for equal parts of the whole length.
fn kept_at(at: vec2f, length: f32, first: u32) -> vec4f {
  if (!LAYERED) { return layer_at(slabs, slabs_sampler, at, first); }
  let last = params.slab_lengths - 1u;
  let layer = clamp(length / params.slab_length * f32(params.slab_lengths) - 1.0, 0.0, f32(last));
  let low = u32(layer);
  let a = layer_at(slabs, slabs_sampler, at, first + low);
  let b = layer_at(slabs, slabs_sampler, at, first + min(low + 1u, last));
  return mix(a, b, fract(layer));
}
