// Transfer functions as the device reads them: what transfer/cells.py and transfer/tables.py make, for any control points.
// A function is { points: [[value, [r, g, b], extinction], ...], associated }.

const GRID = 64;
const BINS = 256;
const ROW_WIDTH = 64;
const ROWS_PER_CELL = 5;
const ROWS_PER_ENTRY = 3;
const ROWS_PER_PIECE = 3;
const FAR = 3e38;
const SIZES = [128, 256, 512];
const ENTRIES_PER_SEGMENT = 4;

/** First index whose number is greater than one (or as great, `orEqual`). */
function searched(numbers, one, orEqual = false) {
  let low = 0;
  let high = numbers.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numbers[middle] < one || (!orEqual && numbers[middle] === one)) low = middle + 1;
    else high = middle;
  }
  return low;
}

const clamped = (x, low, high) => Math.min(Math.max(x, low), high);
const rising = (numbers) => [...new Set(numbers)].sort((a, b) => a - b);
const spread = (first, last, count) =>
  Array.from({ length: count }, (_, n) => (n === count - 1 ? last : first + n * ((last - first) / (count - 1))));

/** [r, g, b, extinction] at a value; at a step the later point holds. */
export function mediumAt(points, value, values = points.map((p) => p[0])) {
  const above = searched(values, value);
  const lower = points[clamped(above - 1, 0, points.length - 1)];
  const upper = points[clamped(above, 0, points.length - 1)];
  const width = upper[0] - lower[0];
  const share = width > 0 ? (value - lower[0]) / width : 0;
  const mix = (a, b) => a * (1 - share) + b * share;
  return [...lower[1].map((c, n) => mix(c, upper[1][n])), mix(lower[2], upper[2])];
}

/** First and last value of the axis; a function of one value gets a narrow axis round it. */
export function valueAxis(points) {
  const [first, last] = [points[0][0], points[points.length - 1][0]];
  if (last > first) return [first, last];
  const width = 1e-3 * Math.abs(first) || 1e-6;
  return [first - width / 2, last + width / 2];
}

function meanSource(low, high, associated) {
  return [0, 1, 2].map((c) => {
    if (associated) return (low[c] + high[c]) / 2;
    const [riseColour, rise] = [high[c] - low[c], high[3] - low[3]];
    return low[c] * low[3] + (low[c] * rise + riseColour * low[3]) / 2 + (riseColour * rise) / 3;
  });
}

/** Cells between rising borders, all control points among them: media inside both ends, and the integral up to each border. */
function cutAt({ points, associated }, borders) {
  const values = points.map((p) => p[0]);
  const span = borders[borders.length - 1] - borders[0];
  const cells = { borders, low: [], high: [], integral: [[0, 0, 0, 0]], associated };
  for (let n = 0; n + 1 < borders.length; n++) {
    const width = borders[n + 1] - borders[n];
    const [near, far] = [0.25, 0.75].map((q) => mediumAt(points, borders[n] + q * width, values));
    const low = near.map((x, c) => Math.max(1.5 * x - 0.5 * far[c], 0));
    const high = far.map((x, c) => Math.max(1.5 * x - 0.5 * near[c], 0));
    const step = [...meanSource(low, high, associated), (low[3] + high[3]) / 2];
    cells.low.push(low);
    cells.high.push(high);
    cells.integral.push(cells.integral[n].map((sum, c) => sum + step[c] * (width / span)));
  }
  return cells;
}

/** Cut at the control points, and at a grid where none is near. */
function cellsOf(given) {
  const [first, last] = valueAxis(given.points);
  const known = rising([first, ...given.points.map((p) => p[0]), last]);
  const width = (last - first) / GRID;
  const free = spread(first, last, GRID + 1).filter((value) => {
    const above = clamped(searched(known, value, true), 1, known.length - 1);
    return Math.min(Math.abs(value - known[above - 1]), Math.abs(known[above] - value)) > 1e-3 * width;
  });
  return cutAt(given, rising([...known, ...free]));
}

/** Cut at the control points alone. */
function piecesOf(given) {
  const [first, last] = valueAxis(given.points);
  return cutAt(given, rising([first, ...given.points.map((p) => p[0]).filter((v) => v > first && v < last), last]));
}

function integralTo(cells, value) {
  const { borders } = cells;
  const [first, last] = [borders[0], borders[borders.length - 1]];
  const held = clamped(value, first, last);
  const n = clamped(searched(borders, held) - 1, 0, cells.low.length - 1);
  const width = borders[n + 1] - borders[n];
  const w = (held - borders[n]) / width;
  const low = cells.low[n];
  const here = low.map((x, c) => x + w * (cells.high[n][c] - x));
  const part = [...meanSource(low, here, cells.associated), (low[3] + here[3]) / 2];
  return cells.integral[n].map((sum, c) => sum + (w * part[c] * width) / (last - first));
}

const highParts = (numbers) => numbers.map(Math.fround);
const lowParts = (numbers) => numbers.map((x) => Math.fround(x - Math.fround(x)));

/** Rows of a texture 64 wide, lines by a power of two: bins, then five rows a cell. `rows`: "cells" or "pieces". */
export function functionRows(given, rows = "cells") {
  const cells = rows === "pieces" ? piecesOf(given) : cellsOf(given);
  const { borders } = cells;
  const count = cells.low.length;
  const [first, last] = [borders[0], borders[count]];
  const lines = Math.ceil((BINS + ROWS_PER_CELL * count) / ROW_WIDTH);
  const height = 2 ** Math.ceil(Math.log2(lines));
  const texels = new Float32Array(4 * ROW_WIDTH * height);
  const put = (row, numbers) => texels.set(numbers, 4 * row);
  const heads = cells.low.map((_, n) => [
    borders[n],
    n === count - 1 ? 3.4028234663852886e38 : borders[n + 1],
    1 / (borders[n + 1] - borders[n]),
  ]);
  for (let bin = 0; bin < BINS; bin++) {
    const edge = first + ((bin - 1e-3) / BINS) * (last - first);
    const n = clamped(searched(borders, edge) - 1, 0, count - 1);
    put(bin, [BINS + ROWS_PER_CELL * n, ...heads[n]]);
  }
  heads.forEach((head, n) => {
    const row = BINS + ROWS_PER_CELL * n;
    put(row, head);
    put(row + 1, cells.low[n]);
    put(row + 2, cells.high[n]);
    put(row + 3, highParts(cells.integral[n]));
    put(row + 4, lowParts(cells.integral[n]));
  });
  return { width: ROW_WIDTH, height, texels };
}

/** Rows that a table of slabs is made of: three an entry, then three a piece; see transfer/tables.py. */
export function segmentRows(given, entries) {
  const [first, last] = valueAxis(given.points);
  const ends = spread(first, last, entries);
  const segment = (last - first) / (entries - 1);
  const pieces = piecesOf(given).borders;
  for (const point of pieces.slice(1, -1)) {
    const nearest = Math.round((point - first) / segment);
    if (Math.abs(point - ends[nearest]) < 1e-6 * segment) ends[nearest] = point;
  }
  const cells = cutAt(given, rising([...ends, ...pieces]));
  const count = cells.low.length;
  const texels = new Float32Array(4 * (ROWS_PER_ENTRY * entries + ROWS_PER_PIECE * count));
  const put = (row, numbers) => texels.set(numbers, 4 * row);
  const entryAt = new Map(ends.map((value, n) => [value, n]));
  ends.forEach((value, n) => {
    const begins = searched(cells.borders, value, true);
    const row = ROWS_PER_ENTRY * n;
    put(row, [begins, mediumAt(given.points, value)[3]]);
    put(row + 1, highParts(cells.integral[begins]));
    put(row + 2, lowParts(cells.integral[begins]));
  });
  for (let n = 0; n < count; n++) {
    const width = (cells.borders[n + 1] - cells.borders[n]) / segment;
    const row = ROWS_PER_ENTRY * entries + ROWS_PER_PIECE * n;
    const at = (value) => entryAt.get(value) ?? -1;
    const depth = (width * (cells.low[n][3] + cells.high[n][3])) / 2;
    put(row, [width, at(cells.borders[n]), at(cells.borders[n + 1]), depth]);
    put(row + 1, cells.low[n]);
    put(row + 2, cells.high[n]);
  }
  return texels;
}

/** Entries of a table whose narrowest segment gets at least four, from those that it had first up to the greatest size. */
export function entriesFor({ points }, least) {
  const [first, last] = valueAxis(points);
  const gaps = points.slice(1).map((p, n) => p[0] - points[n][0]).filter((gap) => gap > 0);
  const wanted = (ENTRIES_PER_SEGMENT * (last - first)) / Math.min(...gaps, last - first);
  const size = SIZES.find((one) => one >= wanted) ?? SIZES[SIZES.length - 1];
  return Math.max(size, least);
}

function justBelow(value) {
  const float = new Float32Array([value]);
  const bits = new Int32Array(float.buffer);
  if (float[0] === 0) return -1.401298464324817e-45;
  bits[0] += float[0] > 0 ? -1 : 1;
  return float[0];
}

/** Intervals of values, ends included, on which extinction and source are zero. */
export function emptyStretches({ points, associated }) {
  const found = [];
  let low = -Infinity;
  let last = -Infinity;
  for (const [value, rgb, extinction] of points) {
    if (extinction > 0 || (associated && Math.max(...rgb) > 0)) {
      const end = value === last ? justBelow(last) : last;
      if (low !== null && end > low) found.push([low, end]);
      low = null;
    } else if (low === null) {
      low = value;
    }
    last = value;
  }
  if (low !== null) found.push([low, Infinity]);
  return found;
}

/** Values of a transfer stage's uniforms, by the names of its layout; matrices as lists of columns. */
export function functionUniforms(given, slabs = null) {
  const { points } = given;
  const [first, last] = valueAxis(points);
  const width = ([low, high]) => high - low;
  const wider = (a, b) => (width(a) === width(b) ? 0 : width(a) > width(b) ? -1 : 1);
  const stretches = emptyStretches(given).sort(wider).slice(0, 4);
  const ends = [0, 1, 2, 3].map((n) => (stretches[n] ? stretches[n].map((x) => clamped(x, -FAR, FAR)) : [FAR, -FAR]));
  const cells = cellsOf(given);
  const integrals = ends.map(([low]) => integralTo(cells, Math.max(low, first)));
  const medium = ([, rgb, extinction]) => [...rgb, extinction];
  return {
    first_value: first,
    last_value: last,
    per_value: 1 / (last - first),
    even_cells: 0,
    empty_low: ends.map((end) => end[0]),
    empty_high: ends.map((end) => end[1]),
    empty_integral_high: integrals.map(highParts),
    empty_integral_low: integrals.map(lowParts),
    first_medium: medium(points[0]),
    last_medium: medium(points[points.length - 1]),
    slab_entries: slabs ? slabs.entries : 2,
    slab_lengths: slabs ? slabs.lengths : 1,
    slab_length: slabs ? slabs.length : 1,
  };
}
