// A slab is a homogeneous medium: the mean of the media at its two ends, each of which stands for half of it.

import package::sample::{Sample, Medium, Slab};
import package::transfer::cells::source_of;
import package::transfer::function::{function_at, is_empty_between};
import package::optics::make_slab;

alias Known = Medium;

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn know(here: Sample) -> Known { return medium(here); }

fn know_empty(here: Sample) -> Known { return Known(vec3f(0.0), 0.0); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_known(front, know(front), back, know(back), length);
}

fn classify_known(front: Sample, front_known: Known, back: Sample, back_known: Known, length: f32) -> Slab {
  let source = 0.5 * (source_of(front_known) + source_of(back_known));
  return make_slab(source, 0.5 * (front_known.extinction + back_known.extinction), length);
}
