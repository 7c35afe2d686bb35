// A slab is a homogeneous medium: the mean of the media at its two ends, each of which stands for half of it.

import package::sample::{Sample, Medium, Slab};
import package::transfer::function::{function_at, source_of, is_empty_between};
import package::optics::make_slab;

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_media(medium(front), medium(back), length);
}

// The same for a driver that keeps the medium at the back, which is at the front of the next slab.
fn classify_media(front: Medium, back: Medium, length: f32) -> Slab {
  let source = 0.5 * (source_of(front) + source_of(back));
  return make_slab(source, 0.5 * (front.extinction + back.extinction), length);
}
