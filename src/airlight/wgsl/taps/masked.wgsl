// What voxels add to sums over samples of one channel of which some are empty: those that are there, and their weights. Sums are
// divided by the weight; there is nothing where it is below half.

import generated::sizes::Values;
import package::empty::{EMPTY, is_empty};
import slot::voxels::texel_at;

alias Tap = vec2f;

const PARTS: u32 = 1u;

fn tap(voxel: vec3i, part: u32) -> Tap {
  let texel = texel_at(voxel).r;
  return select(vec2f(texel, 1.0), vec2f(0.0), is_empty(texel));
}

fn keep_sum(sum: Tap, part: u32, values: ptr<function, Values>) { *values = select(sum.x / max(sum.y, 0.5), EMPTY, sum.y < 0.5); }

fn slope_of_sum(sum: Tap, change: Tap, part: u32) -> f32 {
  let weight = max(sum.y, 0.5);
  return select((change.x - sum.x / weight * change.y) / weight, 0.0, sum.y < 0.5);
}

fn scalar_in(values: Values) -> f32 { return values; }
