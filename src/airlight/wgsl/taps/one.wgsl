// What voxels add to sums over samples of one channel. Fields that are weighted sums are written in these names; the other files
// of this folder exchange them. Sums of taps are linear: they may be multiplied by numbers and added.
// They begin with `Tap()`, said in words: what a loop declares without a value keeps that of the turn before (naga 22).

import generated::layer::layer;
import generated::sizes::Values;
import slot::voxels::texel_at;

alias Tap = f32;

const PARTS: u32 = 1u;  // of a value, each summed up by itself

fn tap(voxel: vec3i, part: u32) -> Tap { return texel_at(voxel).r; }

// Put the value of a sum, whose weights are one together, into a part of what a field returns.
fn keep_sum(sum: Tap, part: u32, values: ptr<function, Values>) { *values = sum * layer.value_scale + layer.value_offset; }

// What a part adds to the derivative of the number of which gradients are taken, by its sum and the derivative of that.
fn slope_of_sum(sum: Tap, change: Tap, part: u32) -> f32 { return change * layer.value_scale; }

// The number of which gradients are taken.
fn scalar_in(values: Values) -> f32 { return values; }
