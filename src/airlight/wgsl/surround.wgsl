// Luminance round pixels: see `passes/surround.wgsl`.

import generated::pass::{surround, surround_sampler};
import generated::sizes::SURROUND_STEPS;
import generated::surround::params;
import package::surround_steps::{step_of, stops_of};
import slot::lookup::table_at;

const LEAST_SHARE: f32 = 1e-6;  // of a cell's pixels: where fewer are about as bright, the pixel's own luminance is taken

fn surround_at(p_px: vec2f, luminance: f32) -> f32 {
  let stops = stops_of(luminance);
  let place = vec3f(p_px / (f32(params.cell_px) * vec2f(params.cells)), step_of(stops) / f32(SURROUND_STEPS));
  let found = table_at(surround, surround_sampler, place);
  return exp2(params.middle_stops + (found.x + LEAST_SHARE * stops) / (found.y + LEAST_SHARE));
}
