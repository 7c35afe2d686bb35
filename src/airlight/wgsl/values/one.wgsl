// Samples of one channel.

import generated::sizes::Values;
import package::empty::is_empty;

fn mix_values(a: Values, b: Values, share: f32) -> Values { return mix(a, b, share); }

// The number by which a sample is compared and of which gradients are taken.
fn scalar_of(value: Values) -> f32 { return value; }

// The sample with another number to be compared by.
fn with_scalar(value: Values, scalar: f32) -> Values { return scalar; }

// Whether the sample holds nothing.
fn is_gap(value: Values) -> bool { return is_empty(value); }

// The first value where a sample holds something, the other where it does not.
fn where_there(here: Values, value: Values, other: Values) -> Values { return select(value, other, is_empty(here)); }

fn channel_of(value: Values, channel: u32) -> f32 { return value; }
