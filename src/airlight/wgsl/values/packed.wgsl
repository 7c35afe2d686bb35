// Samples of several channels, four to a vector.

import generated::sizes::{Values, GROUPS};
import package::empty::EMPTY;

fn mix_values(a: Values, b: Values, share: f32) -> Values {
  var mixed: Values;
  for (var group = 0u; group < GROUPS; group++) { mixed[group] = mix(a[group], b[group], share); }
  return mixed;
}

// The number by which a sample is compared and of which gradients are taken: fields may know a better one.
fn scalar_of(value: Values) -> f32 { return value[0].x; }

// The sample with another number to be compared by.
fn with_scalar(value: Values, scalar: f32) -> Values {
  var changed = value;
  changed[0].x = scalar;
  return changed;
}

// Whether the sample holds nothing in any channel.
fn is_gap(value: Values) -> bool {
  var gaps = vec4<bool>(true);
  for (var group = 0u; group < GROUPS; group++) { gaps &= value[group] <= vec4f(EMPTY); }
  return all(gaps);
}

// The first value where a sample holds something, the other where it does not, channel by channel.
fn where_there(here: Values, value: Values, other: Values) -> Values {
  var chosen: Values;
  for (var group = 0u; group < GROUPS; group++) {
    chosen[group] = select(value[group], other[group], here[group] <= vec4f(EMPTY));
  }
  return chosen;
}

fn channel_of(value: Values, channel: u32) -> f32 { return value[channel / 4u][channel % 4u]; }
