// Surfaces of equal value that the driver cuts out of slabs one by one, and the medium between them.

import generated::sizes::Values;
import generated::transfer::IN_MEDIUM;
import package::sample::{Sample, Medium, Slab, Sheet};
import package::transfer::cells::Reached;
import package::transfer::function::{function_at, is_empty_between, reach, reach_empty};
import package::transfer::held::held_on_stretch;
import package::transfer::iso_values::{number_of, surface_value, side_of, reach_surface};
import slot::piece::between;

alias Known = Reached;

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn know(here: Sample) -> Known { return reach(here.value); }

fn know_empty(here: Sample) -> Known { return reach_empty(here.value); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

fn held(found: Values, moved: Values) -> Values { return held_on_stretch(found, moved); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_known(front, know(front), back, know(back), length);
}

fn classify_known(front: Sample, front_known: Known, back: Sample, back_known: Known, length: f32) -> Slab {
  if (!IN_MEDIUM) { return Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0); }
  return between(front.value, front_known, back.value, back_known, length);
}

fn next_crossing(front: Sample, back: Sample, passed: u32) -> Sheet {
  let front_number = number_of(front.value);
  let back_number = number_of(back.value);
  let rises = back_number > front_number;
  let count = select(front_number - back_number, back_number - front_number, rises);
  if (passed >= count) { return Sheet(2.0, 0.0, 0u, rises, vec3f(0.0), 0.0); }
  let number = select(front_number - 1u - passed, front_number + passed, rises);
  let level = surface_value(number);
  let side = side_of(number, rises);
  return Sheet(saturate((level - front.value) / (back.value - front.value)), level, number, rises, side.rgb, side.a);
}

fn know_crossing(sheet: Sheet, hit: Sample, behind: bool) -> Known {
  return reach_surface(sheet.number, sheet.rises == behind);
}
