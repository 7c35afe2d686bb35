// Sums of stops of luminance, and of their weights, over the pixels of each cell by steps of luminance. A pixel belongs to the
// nearest steps by a cubic B-spline, and counts as much as it is covered. One thread a cell; of a tile as wide
// as the image, whose sums are added to those of others.

import generated::frame::frame;
import generated::pass::{radiance, surround_sums};
import generated::sizes::{SURROUND_STEPS, WORKGROUP_X, WORKGROUP_Y};
import generated::surround::params;
import package::colour::luminance;
import package::surround_steps::{step_of, stops_of};

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let cell = vec2u(id.x, frame.tile_origin_px.y / params.cell_px + id.y);
  if (any(cell >= params.cells)) { return; }
  let first = max(cell * params.cell_px, frame.tile_origin_px);
  let last = min((cell + 1u) * params.cell_px, frame.tile_origin_px + frame.tile_size_px);
  var sums = array<vec2f, SURROUND_STEPS>();
  for (var y = first.y; y < last.y; y++) {
    let row = (y - frame.band_first_row) * frame.size_px.x;
    for (var x = first.x; x < last.x; x++) {
      let pixel = radiance[row + x];
      let stops = stops_of(luminance(pixel.rgb));
      let place = step_of(stops) - 0.5;
      let w = place - floor(place);
      let v = 1.0 - w;
      let step = u32(place);
      let term = pixel.a / 6.0 * vec2f(stops, 1.0);
      sums[step - 1u] += v * v * v * term;
      sums[step] += (4.0 - 3.0 * w * w * (2.0 - w)) * term;
      sums[step + 1u] += (4.0 - 3.0 * v * v * (2.0 - v)) * term;
      sums[step + 2u] += w * w * w * term;
    }
  }
  for (var step = 0u; step < SURROUND_STEPS; step++) {
    surround_sums[(step * params.cells.y + cell.y) * params.cells.x + cell.x] += sums[step];
  }
}
