// Surfaces of equal value, from the rows of `transfer/crossings.py`: how many lie below a value, and what is known at each.

import generated::transfer::{params, surfaces};
import package::transfer::cells::Reached;

const ROWS_IN_LINE = 64u;

// How many iso-values lie at or below a value: its number. Values on an iso-value are above it.
fn number_of(value: f32) -> u32 {
  let place = saturate((value - params.surface_first) * params.surface_per_value) * f32(params.surface_bins);
  let bin = surface_row(min(u32(place), params.surface_bins - 1u));
  var number = u32(bin.x) + u32(value >= bin.y) + u32(value >= bin.z) + u32(value >= bin.w);
  if (value >= bin.w) {
    while (number < params.surface_count && value >= surface_value(number)) { number++; }
  }
  return number;
}

fn surface_row(row: u32) -> vec4f { return textureLoad(surfaces, vec3u(row % ROWS_IN_LINE, row / ROWS_IN_LINE, 0u), 0); }

fn surface_value(number: u32) -> f32 { return surface_row(params.surface_bins + number * params.surface_rows).x; }

// Colour and opacity of the side that a ray sees whose values rise through the surface, or fall.
fn side_of(number: u32, rises: bool) -> vec4f {
  return surface_row(params.surface_bins + number * params.surface_rows + select(2u, 1u, rises));
}

// What is known of the medium at a surface, as seen from the side towards higher or lower values.
fn reach_surface(number: u32, above: bool) -> Reached {
  let row = params.surface_bins + number * params.surface_rows;
  let held = clamp(surface_row(row).x, params.first_value, params.last_value);
  return Reached(held, surface_row(row + select(5u, 6u, above)), surface_row(row + 3u), surface_row(row + 4u));
}
