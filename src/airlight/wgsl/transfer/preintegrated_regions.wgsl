// Each function integrated along the straight line between a slab's two values, by the regions in its middle: a slab is drawn as if
// all it holds were spread evenly along it.

import generated::sizes::Values;
import package::optics::make_slab;
import package::sample::{Sample, Medium, Slab};
import package::transfer::axes::axis_of;
import package::transfer::cells::function_count;
import package::transfer::held::held_on_stretch;
import package::transfer::regions::{is_empty_in_all, region_medium};
import package::transfer::straight::mean_along;
import slot::region::shares_at;

fn medium(here: Sample) -> Medium { return region_medium(here); }

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_in_all(front.value, back.value); }

fn held(found: Values, moved: Values) -> Values { return held_on_stretch(found, moved); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  let shares = shares_at(mix(front.p_index, back.p_index, 0.5));
  var sum = vec4f(0.0);
  for (var number = 0u; number < function_count(); number++) {
    sum += mean_along(axis_of(number), front.value, back.value) * shares.by_function[number];
  }
  return make_slab(sum.rgb, sum.a, length);
}
