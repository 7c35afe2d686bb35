// Light of stretches of a transfer function, for rays that run through it up and down in value; its pieces, as
// `transfer/tables.py` cuts them.

import generated::pass::segments;
import generated::sizes::WEIGHTED;
import generated::slab_table::params;
import package::transfer::linear::sums_over;

const ROWS_PER_ENTRY = 3u;
const ROWS_PER_PIECE = 3u;

// Parts of a piece are at most this deep, which eight nodes integrate to 1e-6; what lies more than three parts deep from both
// ends of a piece is not seen. Few parts: lavapipe ends loops after 65,536 turns.
const PART_DEPTH = 4.5;
const SEEN_PARTS = 3.0;
const MOST_PARTS = 2.0 * SEEN_PARTS + 1.0;

// What a stretch of values sends to one of its ends, and that weighted by how far from this end it comes, in segments. In the
// fourth place is white light, that of a colour of one: opacity.
struct Sent { light: vec4f, moment: vec4f }

// A stretch of values: its width in segments, what it lets through, and what it sends to its low and to its high end.
struct Stretch { width: f32, through: f32, to_low: Sent, to_high: Sent }

fn nothing() -> Stretch { return Stretch(0.0, 1.0, Sent(vec4f(0.0), vec4f(0.0)), Sent(vec4f(0.0), vec4f(0.0))); }

fn joined(low: Stretch, high: Stretch) -> Stretch {
  let through = passed(vec4f(high.through), low).x;
  return Stretch(
    low.width + high.width,
    through,
    before(low.to_low, low, high.to_low),
    before(high.to_high, high, low.to_high),
  );
}

// What a stretch sends together with what another one sends through it.
fn before(sent: Sent, stretch: Stretch, other: Sent) -> Sent {
  var both = Sent(sent.light + passed(other.light, stretch), vec4f(0.0));
  if (WEIGHTED) { both.moment = sent.moment + passed(other.moment + stretch.width * other.light, stretch); }
  return both;
}

// What of some light gets through a stretch. Thousands of thin pieces must not add up what each is rounded by: where little is
// absorbed that is the exact number.
fn passed(light: vec4f, stretch: Stretch) -> vec4f {
  let opacity = stretch.to_low.light.a;
  return select(light - opacity * light, stretch.through * light, opacity > 0.5);
}

// A piece of a segment in which colour and extinction are linear: width in segments, the entries at its two ends (-1 where none
// is), and its depth when slabs have a length of one a segment.
struct Piece { width: f32, low_entry: i32, high_entry: i32, depth: f32, low: vec4f, high: vec4f }

fn piece_at(number: u32) -> Piece {
  let row = params.entries * ROWS_PER_ENTRY + number * ROWS_PER_PIECE;
  let head = segments[row];
  return Piece(head.x, i32(head.y), i32(head.z), head.w, segments[row + 1u], segments[row + 2u]);
}

fn first_piece(entry: u32) -> u32 { return u32(segments[ROWS_PER_ENTRY * entry].x); }

fn extinction_at(entry: u32) -> f32 { return segments[ROWS_PER_ENTRY * entry].y; }

// Mean source and extinction between two entries, from the function's integral as a sum of two numbers.
fn mean_between(low: u32, high: u32) -> vec4f {
  let a = low * ROWS_PER_ENTRY;
  let b = high * ROWS_PER_ENTRY;
  let difference = (segments[b + 1u] - segments[a + 1u]) + (segments[b + 2u] - segments[a + 2u]);
  return max(difference * (f32(params.entries - 1u) / f32(high - low)), vec4f(0.0));
}

fn parts_of(depth: f32) -> f32 { return clamp(ceil(depth / PART_DEPTH), 1.0, MOST_PARTS); }

// One of the parts of a piece, whose segments have a length of `rate`.
fn part_of(piece: Piece, number: f32, parts: f32, rate: f32) -> Stretch {
  let slope = (piece.high.a - piece.low.a) / max(piece.high.a + piece.low.a, 1e-30);
  let begin = part_begin(number, parts, rate * piece.depth, slope);
  let end = part_begin(number + 1.0, parts, rate * piece.depth, slope);
  return part_stretch(mix(piece.low, piece.high, begin), mix(piece.low, piece.high, end), piece.width * (end - begin), rate);
}

// Where in its piece a part begins. Parts are equally deep, but for the one in the middle of a piece that is deeper.
fn part_begin(number: f32, parts: f32, depth: f32, slope: f32) -> f32 {
  let each = min(1.0 / parts, PART_DEPTH / max(depth, 1e-30));
  let share = select(1.0 - (parts - number) * each, number * each, number <= SEEN_PARTS);
  // Depth grows as (1 - slope) x + slope x^2.
  let flat = 1.0 - slope;
  let x = 2.0 * share / max(flat + sqrt(max(flat * flat + 4.0 * slope * share, 0.0)), 1e-30);
  return select(select(min(x, 1.0), 1.0, number == parts), 0.0, number == 0.0);
}

fn part_stretch(low: vec4f, high: vec4f, width: f32, rate: f32) -> Stretch {
  let length = rate * width;
  let rise = high - low;
  let depth = length * (low.a + 0.5 * rise.a);
  let through = exp(-depth);
  let sums = sums_over(low.a, rise.a, length, through, params.associated != 0u);
  // Where little is absorbed one minus what gets through has few digits.
  let alpha = select(sums.white, 1.0 - through, depth > 0.5);
  var to_low = sums.to_low;
  var to_high = sums.to_high;
  to_low.x = select(to_low.x, alpha, params.associated == 0u);
  to_high.x = select(to_high.x, alpha, params.associated == 0u);
  return Stretch(
    width,
    through,
    sent(low.rgb, rise.rgb, to_low, alpha, width),
    sent(high.rgb, -rise.rgb, to_high, alpha, width),
  );
}

// What colours send that rise linearly from the end that is looked at.
fn sent(rgb: vec3f, rise: vec3f, sums: vec4f, alpha: f32, width: f32) -> Sent {
  var both = Sent(vec4f(rgb * sums.x + rise * sums.y, alpha), vec4f(0.0));
  if (WEIGHTED) { both.moment = width * vec4f(rgb * sums.y + rise * sums.z, sums.w); }
  return both;
}
