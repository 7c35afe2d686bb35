// Surfaces of equal value with nothing between them: a slab is told by the two numbers of its ends.

import generated::sizes::Values;
import package::optics::thicker;
import package::sample::{Sample, Medium, Slab};
import package::transfer::function::{function_at, is_empty_between};
import package::transfer::held::held_on_stretch;
import package::transfer::iso_values::number_of;
import package::transfer::surfaces::{crossing_of, step_on, light_at, moment_at, crossed, thickness_of, thinned};
import slot::values::scalar_of;

struct Known { number: u32 }

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn know(here: Sample) -> Known { return Known(number_of(here.value)); }

fn know_empty(here: Sample) -> Known { return know(here); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

fn held(found: Values, moved: Values) -> Values { return held_on_stretch(found, moved); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_known(front, know(front), back, know(back), length);
}

fn classify_known(front: Sample, front_known: Known, back: Sample, back_known: Known, length: f32) -> Slab {
  let crossing = crossing_of(front.value, front_known.number, back.value, back_known.number);
  let slab = crossed(crossing, light_at(crossing, 0u), moment_at(crossing, 0u));
  return thinned(slab, 1.0 - thicker(1.0 - slab.alpha, thickness_of(front, back, length)));
}

// At the first surface behind which there is enough; the run is halved until it is found.
fn opacity_share(front: Sample, back: Sample, length: f32, alpha: f32, wanted: f32) -> f32 {
  let s_front = scalar_of(front.value);
  let thickness = thickness_of(front, back, length);
  let from_number = number_of(s_front);
  let to_number = number_of(scalar_of(back.value));
  let rises = to_number > from_number;
  var low = 1u;
  var high = max(select(from_number - to_number, to_number - from_number, rises), 1u);
  while (low < high) {
    let middle = (low + high) / 2u;
    let crossing = crossing_of(s_front, from_number, scalar_of(back.value), step_on(from_number, middle, rises));
    let enough = 1.0 - thicker(1.0 - light_at(crossing, 0u).a, thickness) >= wanted;
    low = select(middle + 1u, low, enough);
    high = select(high, middle, enough);
  }
  return crossing_of(s_front, from_number, scalar_of(back.value), step_on(from_number, low, rises)).last;
}
