// Several channels in one place: the value of each one in a sample, and what is empty.

import generated::transfer::params;
import generated::sizes::{Values, GROUPS};
import package::sample::Sample;
import slot::values::channel_of;

fn value_of(values: Values, number: u32) -> f32 {
  return channel_of(values, u32(params.lane[number / 4u][number % 4u]));
}

// Whether each channel stays on one of the (at most two) stretches on which its function holds nothing.
fn is_empty_slab(front: Sample, back: Sample) -> bool {
  var empty = vec4<bool>(true);
  for (var group = 0u; group < GROUPS; group++) {
    let low = min(front.value[group], back.value[group]);
    let high = max(front.value[group], back.value[group]);
    let one = (low >= params.empty_low[group]) & (high <= params.empty_high[group]);
    let other = (low >= params.other_empty_low[group]) & (high <= params.other_empty_high[group]);
    empty &= one | other;
  }
  return all(empty);
}

// Each channel's value stays on the stretch that it lies on: see `held.wgsl`.
fn held_on_stretches(found: Values, moved: Values) -> Values {
  var values = moved;
  for (var group = 0u; group < GROUPS; group++) {
    let one = (found[group] >= params.empty_low[group]) & (found[group] <= params.empty_high[group]);
    let other = (found[group] >= params.other_empty_low[group]) & (found[group] <= params.other_empty_high[group]);
    let low = select(select(vec4f(-3.4e38), params.empty_low[group], one), params.other_empty_low[group], other);
    let high = select(select(vec4f(3.4e38), params.empty_high[group], one), params.other_empty_high[group], other);
    values[group] = clamp(moved[group], low, high);
  }
  return values;
}
