// Several channels, a slab the mean of the media at its two ends: extinctions add, and so do sources.

import generated::transfer::ASSOCIATED;
import generated::sizes::HAS_EMPTY;
import package::empty::is_empty;
import package::optics::make_slab;
import package::sample::{Sample, Medium, Slab};
import package::transfer::axes::axis_of;
import package::transfer::cells::{function_count, medium_on, source_of};
import package::transfer::channels::{is_empty_slab, value_of};

struct Known { medium: vec4f }  // source and extinction [1/world]

fn know(here: Sample) -> Known {
  var sum = vec4f(0.0);
  for (var number = 0u; number < function_count(); number++) {
    let value = value_of(here.value, number);
    let medium = medium_on(axis_of(number), value);
    // A channel without a sample holds nothing.
    sum += select(vec4f(source_of(medium), medium.extinction), vec4f(0.0), HAS_EMPTY && is_empty(value));
  }
  return Known(sum);
}

fn know_empty(here: Sample) -> Known { return Known(vec4f(0.0)); }

fn medium(here: Sample) -> Medium {
  let sum = know(here).medium;
  return Medium(select(sum.rgb / max(sum.a, 1e-37), sum.rgb, ASSOCIATED), sum.a);
}

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_slab(front, back); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_known(front, know(front), back, know(back), length);
}

fn classify_known(front: Sample, front_known: Known, back: Sample, back_known: Known, length: f32) -> Slab {
  let mean = 0.5 * (front_known.medium + back_known.medium);
  return make_slab(mean.rgb, mean.a, length);
}
