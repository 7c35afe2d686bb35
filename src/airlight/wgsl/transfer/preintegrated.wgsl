// A slab is the function integrated along the straight line between its two values.

import generated::transfer::{params, slabs, slabs_sampler};
import package::sample::{Sample, Medium, Slab};
import package::transfer::function::{function_at, is_empty_between};
import package::optics::{make_slab, over};
import slot::lookup::table_at;

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

// Beyond its ends the function is constant: a slab is a homogeneous piece, one from the table, and another homogeneous one.
fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  let s_front = clamp(front.value, params.first_value, params.last_value);
  let s_back = clamp(back.value, params.first_value, params.last_value);
  let per_value = select(0.0, length / abs(back.value - front.value), s_front != s_back);
  let before = abs(s_front - front.value) * per_value;
  let after = abs(back.value - s_back) * per_value;
  let inside = slab_between(s_front, s_back, max(length - before - after, 0.0));
  return over(beyond(front.value, before), over(inside, beyond(back.value, after)));
}

fn beyond(value: f32, length: f32) -> Slab {
  let medium_there = select(params.last_medium, params.first_medium, value < params.first_value);
  return make_slab(medium_there.rgb, medium_there.a, length);
}

// The table holds attenuated mean source and mean extinction [1/world], its third axis the length from 0 to `slab_length`.
fn slab_between(s_front: f32, s_back: f32, length: f32) -> Slab {
  let entries = vec3f(vec2f(f32(params.slab_entries)), f32(params.slab_lengths));
  let place = vec3f((vec2f(s_front, s_back) - params.first_value) * params.per_value, length / params.slab_length);
  let texel = table_at(slabs, slabs_sampler, (place * (entries - 1.0) + 0.5) / entries);
  return make_slab(texel.rgb, texel.a, length);
}
