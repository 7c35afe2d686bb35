// The function integrated along the straight line between a slab's two values; how light is attenuated inside is the stage's choice.

import generated::sizes::Values;
import package::sample::{Sample, Medium, Slab};
import package::transfer::cells::Reached;
import package::transfer::function::{function_at, is_empty_between, reach, reach_empty};
import package::transfer::held::held_on_stretch;
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
  return between(front.value, front_known, back.value, back_known, length);
}
