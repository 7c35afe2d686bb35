// A slab is a homogeneous medium: that of the mean of its two values.

import package::sample::{Sample, Medium, Slab};
import package::transfer::function::{function_at, source_of, is_empty_between};
import package::optics::make_slab;

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  let here = function_at(0.5 * (front.value + back.value));
  return make_slab(source_of(here), here.extinction, length);
}
