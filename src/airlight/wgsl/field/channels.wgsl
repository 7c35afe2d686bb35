// What the fields of several channels share: groups of four, one behind the other along z of the texture.

import generated::field::params;
import generated::sizes::{Values, GROUPS, HAS_EMPTY};
import package::empty::EMPTY;
import slot::values::is_gap;
import slot::voxels::stacked_at;

// A voxel of a group.
fn texel_of(voxel: vec3i, group: u32) -> vec4f { return stacked_at(voxel, params.stacked[group]); }

// The number of which gradients are taken: a weighted sum of the channels, each held within the values that matter.
fn weighted_sum(values: Values) -> f32 {
  var sum = 0.0;
  for (var group = 0u; group < GROUPS; group++) {
    var here = values[group];
    if (HAS_EMPTY) { here = select(here, params.nothing[group], here <= vec4f(EMPTY)); }
    sum += dot(params.weight[group], clamp(here, params.low[group], params.high[group]));
  }
  if (HAS_EMPTY && is_gap(values)) { return EMPTY; }
  return sum;
}

// What a group adds to the derivative of that number: channels that are held do not change it.
fn weighted_slope(value: vec4f, change: vec4f, group: u32) -> f32 {
  let moves = (value >= params.low[group]) & (value <= params.high[group]);
  return dot(params.weight[group], select(vec4f(0.0), change, moves));
}
