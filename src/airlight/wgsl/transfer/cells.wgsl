// Transfer functions at a value, and their integrals up to there, from the cells of `transfer/cells.py`: one function, or several
// behind one another as layers of the texture.

import generated::transfer::{function, ASSOCIATED, EVEN, STEPPED_ENDS};
import package::sample::Medium;

const BINS = 256.0;
const ROWS_PER_CELL = 5u;
const ROW_WIDTH = 64u;

// A function: its layer of the texture, its axis [data], cells where these are equally wide, and the media beyond its ends, which
// matter where there is a step at the very end.
struct Axis {
  layer: u32,
  first_value: f32,
  last_value: f32,
  per_value: f32,
  even_cells: u32,
  first_medium: vec4f,
  last_medium: vec4f,
}

// Told by the texture: software devices compile a loop that a uniform bounds anew for each dispatch.
fn function_count() -> u32 { return textureDimensions(function).z; }

fn row_at(axis: Axis, row: u32) -> vec4f {
  return textureLoad(function, vec3u(row % ROW_WIDTH, row / ROW_WIDTH, axis.layer), 0);
}

// The cell of a value: the row of its colour at the low end, the value's place in it from 0 to 1, and cells per value. Values on a
// border belong to the cell above it.
struct Cell { row: u32, place: f32, per_value: f32 }

fn cell_of(axis: Axis, value: f32) -> Cell {
  let place_unit = saturate((value - axis.first_value) * axis.per_value);
  if (EVEN) {
    let place = place_unit * f32(axis.even_cells);
    let cell = min(u32(place), axis.even_cells - 1u);
    return Cell(cell * (ROWS_PER_CELL - 1u), place - f32(cell), axis.per_value * f32(axis.even_cells));
  }
  let begins = row_at(axis, u32(min(place_unit * BINS, BINS - 1.0)));
  var row = u32(begins.x);
  var head = begins.yzw;
  while (value >= head.y) {
    row += ROWS_PER_CELL;
    head = row_at(axis, row).xyz;
  }
  return Cell(row + 1u, saturate((value - head.x) * head.z), head.z);
}

fn medium_on(axis: Axis, value: f32) -> Medium {
  let cell = cell_of(axis, value);
  let here = beyond_ends(axis, value, mix(row_at(axis, cell.row), row_at(axis, cell.row + 1u), cell.place));
  return Medium(here.rgb, here.a);
}

// The medium inside, or that beyond the end at which a value lies.
fn beyond_ends(axis: Axis, value: f32, inside: vec4f) -> vec4f {
  if (!STEPPED_ENDS) { return inside; }
  return select(select(inside, axis.last_medium, value >= axis.last_value), axis.first_medium, value < axis.first_value);
}

// What is kept of a sample: its value held within the axis; source and extinction there [1/world]; and both integrated over
// the axis up to there, as a sum of two numbers.
struct Reached { value: f32, here: vec4f, high: vec4f, low: vec4f }

fn reach_on(axis: Axis, value: f32) -> Reached {
  let cell = cell_of(axis, value);
  let w = cell.place;
  let start = row_at(axis, cell.row);
  let end = row_at(axis, cell.row + 1u);
  let rise = end - start;
  let here = beyond_ends(axis, value, start + w * rise);
  var part = w * (start + 0.5 * w * rise);
  var source = here.rgb;
  if (!ASSOCIATED) {
    // Colour times extinction, both linear.
    let quadratic = rise.rgb * rise.a;
    part = vec4f(w * (start.rgb * start.a + w * (0.5 * (start.rgb * end.a + end.rgb * start.a) - start.rgb * start.a + w * quadratic / 3.0)), part.a);
    source = here.rgb * here.a;
  }
  let held = clamp(value, axis.first_value, axis.last_value);
  let high = row_at(axis, cell.row + 2u);
  return Reached(held, vec4f(source, here.a), high, row_at(axis, cell.row + 3u) + (axis.per_value / cell.per_value) * part);
}

// Source term [1/world] of a medium.
fn source_of(here: Medium) -> vec3f {
  return here.rgb * select(here.extinction, 1.0, ASSOCIATED);
}
