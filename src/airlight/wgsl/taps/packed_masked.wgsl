// What voxels add to sums over samples of several channels of which some are empty: in the first column those that are there, in
// the second their weights, channel by channel. There is nothing where the weight is below half.

import generated::sizes::{Values, GROUPS};
import package::empty::EMPTY;
import package::field::channels::{texel_of, weighted_slope, weighted_sum};

alias Tap = mat2x4f;

const PARTS: u32 = GROUPS;

fn tap(voxel: vec3i, part: u32) -> Tap {
  let texel = texel_of(voxel, part);
  let gaps = texel <= vec4f(EMPTY);
  return mat2x4f(select(texel, vec4f(0.0), gaps), select(vec4f(1.0), vec4f(0.0), gaps));
}

fn keep_sum(sum: Tap, part: u32, values: ptr<function, Values>) {
  (*values)[part] = select(sum[0] / max(sum[1], vec4f(0.5)), vec4f(EMPTY), sum[1] < vec4f(0.5));
}

fn slope_of_sum(sum: Tap, change: Tap, part: u32) -> f32 {
  let weight = max(sum[1], vec4f(0.5));
  let value = sum[0] / weight;
  let known = (change[0] - value * change[1]) / weight;
  return weighted_slope(value, select(known, vec4f(0.0), sum[1] < vec4f(0.5)), part);
}

fn scalar_in(values: Values) -> f32 { return weighted_sum(values); }
