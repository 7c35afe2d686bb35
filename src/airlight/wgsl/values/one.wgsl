// Samples of one channel.

import generated::sizes::Values;
import package::empty::is_empty;

fn mix_values(a: Values, b: Values, share: f32) -> Values { return mix(a, b, share); }

// The number by which a sample is compared and of which gradients are taken.
fn scalar_of(value: Values) -> f32 { return value; }

// Whether the sample holds nothing.
fn is_gap(value: Values) -> bool { return is_empty(value); }

// Whether any channel of the sample holds nothing.
fn has_gap(value: Values) -> bool { return is_empty(value); }

fn channel_of(value: Values, channel: u32) -> f32 { return value; }
