// A slab is the mean of the media at its two ends, by the functions of the regions in its middle.

import package::optics::make_slab;
import package::sample::{Sample, Medium, Slab};
import package::transfer::axes::axis_of;
import package::transfer::cells::{function_count, medium_on, source_of};
import package::transfer::regions::{is_empty_in_all, region_medium};
import slot::region::shares_at;

fn medium(here: Sample) -> Medium { return region_medium(here); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_in_all(front.value, back.value); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  let shares = shares_at(mix(front.p_index, back.p_index, 0.5));
  var sum = vec4f(0.0);
  for (var number = 0u; number < function_count(); number++) {
    let axis = axis_of(number);
    let one = medium_on(axis, front.value);
    let other = medium_on(axis, back.value);
    let mean = 0.5 * vec4f(source_of(one) + source_of(other), one.extinction + other.extinction);
    sum += mean * shares.by_function[number];
  }
  return make_slab(sum.rgb, sum.a, length);
}
