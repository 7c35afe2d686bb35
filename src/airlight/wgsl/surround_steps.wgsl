// Steps of luminance in which it is averaged round pixels.

import generated::sizes::SURROUND_STEPS;
import generated::surround::params;

const LEAST: f32 = 1e-30;  // luminance

// Stops of a luminance from that in the middle of the steps.
fn stops_of(luminance: f32) -> f32 { return log2(max(luminance, LEAST)) - params.middle_stops; }

// Place among the steps, from 0 to their number; what is brighter or darker than all belongs to the outer ones.
fn step_of(stops: f32) -> f32 {
  let last = f32(SURROUND_STEPS);
  return clamp(0.5 * last + stops / params.step_stops, 2.0, last - 2.0);
}
