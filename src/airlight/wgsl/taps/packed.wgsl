// What voxels add to sums over samples of several channels, four at a time.

import generated::layer::layer;
import generated::sizes::{Values, GROUPS};
import package::field::channels::{texel_of, weighted_slope, weighted_sum};

alias Tap = vec4f;

const PARTS: u32 = GROUPS;

fn tap(voxel: vec3i, part: u32) -> Tap { return texel_of(voxel, part); }

fn keep_sum(sum: Tap, part: u32, values: ptr<function, Values>) {
  (*values)[part] = sum * layer.channel_scale[part] + layer.channel_offset[part];
}

fn slope_of_sum(sum: Tap, change: Tap, part: u32) -> f32 {
  let value = sum * layer.channel_scale[part] + layer.channel_offset[part];
  return weighted_slope(value, change * layer.channel_scale[part], part);
}

fn scalar_in(values: Values) -> f32 { return weighted_sum(values); }
