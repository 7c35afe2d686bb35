// Surfaces of equal value in a medium that is drawn as in `preintegrated.wgsl`.

import generated::sizes::Values;
import package::optics::{over, placed};
import package::sample::{Sample, Medium, Slab};
import package::transfer::cells::Reached;
import package::transfer::function::{function_at, is_empty_between, reach, reach_empty};
import package::transfer::held::held_on_stretch;
import package::transfer::iso_values::{number_of, reach_surface};
import package::transfer::surfaces::{crossing_of, thickness_of};
import package::transfer::surfaces_in_medium::{run_of, share_of_opacity};
import slot::piece::between;
import slot::values::scalar_of;

struct Known { reached: Reached, number: u32 }

fn medium(here: Sample) -> Medium { return function_at(here.value); }

fn know(here: Sample) -> Known { return Known(reach(here.value), number_of(here.value)); }

fn know_empty(here: Sample) -> Known { return Known(reach_empty(here.value), number_of(here.value)); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_between(front.value, back.value); }

fn held(found: Values, moved: Values) -> Values { return held_on_stretch(found, moved); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_known(front, know(front), back, know(back), length);
}

fn classify_known(front: Sample, front_known: Known, back: Sample, back_known: Known, length: f32) -> Slab {
  // One evaluation for slabs without a surface and for the piece before the first: wide processors run both sides of an `if`.
  let crosses = back_known.number != front_known.number;
  let rises = back_known.number > front_known.number;
  let crossing = crossing_of(front.value, front_known.number, back.value, back_known.number);
  let end = select(1.0, crossing.first, crosses);
  var at_end = back_known.reached;
  if (crosses) { at_end = reach_surface(select(front_known.number - 1u, front_known.number, rises), !rises); }
  let value_at_end = select(back.value, crossing.first_value, crosses);
  var slab = placed(between(front.value, front_known.reached, value_at_end, at_end, end * length), 0.0, end);
  if (crosses) {
    let at_last = reach_surface(select(back_known.number, back_known.number - 1u, rises), rises);
    let far = between(crossing.last_value, at_last, back.value, back_known.reached, (1.0 - crossing.last) * length);
    let run = run_of(crossing, length, thickness_of(front, back, length));
    slab = over(slab, over(run, placed(far, crossing.last, 1.0)));
  }
  return slab;
}

fn opacity_share(front: Sample, back: Sample, length: f32, alpha: f32, wanted: f32) -> f32 {
  return share_of_opacity(scalar_of(front.value), scalar_of(back.value), length, thickness_of(front, back, length), wanted);
}
