// Several channels, each one's function integrated along the straight line between a slab's two values. Extinctions add, and so do
// sources: a slab is drawn as if all it holds were spread evenly along it.
//
// Nothing is kept of a sample: of many channels it would be more than processors keep at hand (measured: 3 to 8 times slower).

import generated::transfer::ASSOCIATED;
import generated::sizes::{HAS_EMPTY, Values};
import package::empty::is_empty;
import package::optics::make_slab;
import package::sample::{Sample, Medium, Slab};
import package::transfer::axes::axis_of;
import package::transfer::cells::{function_count, medium_on, source_of};
import package::transfer::channels::{held_on_stretches, is_empty_slab, value_of};
import package::transfer::straight::mean_along;

fn medium(here: Sample) -> Medium {
  var sum = vec4f(0.0);
  for (var number = 0u; number < function_count(); number++) {
    let value = value_of(here.value, number);
    let part = medium_on(axis_of(number), value);
    sum += select(vec4f(source_of(part), part.extinction), vec4f(0.0), HAS_EMPTY && is_empty(value));
  }
  return Medium(select(sum.rgb / max(sum.a, 1e-37), sum.rgb, ASSOCIATED), sum.a);
}

fn empty_slab(front: Sample, back: Sample) -> bool { return is_empty_slab(front, back); }

fn held(found: Values, moved: Values) -> Values { return held_on_stretches(found, moved); }

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  var sum = vec4f(0.0);
  for (var number = 0u; number < function_count(); number++) {
    var s_front = value_of(front.value, number);
    var s_back = value_of(back.value, number);
    var share = 1.0;
    if (HAS_EMPTY) {
      // Where one end has no sample, half of the slab is there, with the sample of the other end.
      let gaps = vec2<bool>(is_empty(s_front), is_empty(s_back));
      share = select(select(1.0, 0.5, any(gaps)), 0.0, all(gaps));
      let held = vec2f(select(s_front, s_back, gaps.x), select(s_back, s_front, gaps.y));
      s_front = held.x;
      s_back = held.y;
    }
    sum += share * mean_along(axis_of(number), s_front, s_back);
  }
  return make_slab(sum.rgb, sum.a, length);
}
