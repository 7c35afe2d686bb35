// Tables by brute force, for `tables.py`: each pair of entries composites all intervals between its two values (Lum, Wilson and
// Ma, section 4.1), one thread a pair. Column front, row back; `params.first_diagonal` and `.diagonals` say which rows.

import generated::pass::{waiting, slab_table_out};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import generated::slab_table::params;
import package::transfer::stretch::{Piece, nothing, joined, piece_at, first_piece, parts_of, part_of};

// `params.layer` says how: the pieces of airlight's own table; the paper's homogeneous intervals, whose opacity is corrected
// in the inner loop; or these corrected for all diagonals beforehand, and how that is done.
const PIECES = 0u;
const INTERVALS = 1u;
const HOISTED = 2u;
const HOIST = 3u;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let i = id.x;
  let j = params.first_diagonal + id.y;
  if (i >= params.entries || id.y >= params.diagonals || j >= params.entries) { return; }
  let count = select(i - j, j - i, j > i);
  let rate = params.length_world / f32(max(count, 1u));
  if (params.layer == PIECES) { keep(i, j, pieces(i, j, rate)); }
  if (params.layer == INTERVALS) { keep(i, j, intervals(i, j, count, rate)); }
  if (params.layer == HOISTED) { keep(i, j, hoisted(i, j, count)); }
  if (params.layer == HOIST) { hoist(i, j); }
}

fn keep(i: u32, j: u32, light: vec4f) { textureStore(slab_table_out, vec2u(i, j), 0u, light); }

// Over the pieces between two entries, turned where the ray runs down: light to one end is all that is asked for.
fn pieces(i: u32, j: u32, rate: f32) -> vec4f {
  let begin = first_piece(min(i, j));
  let end = select(begin, first_piece(max(i, j)), params.layer == PIECES);
  var stretch = nothing();
  var done = 0.0;
  for (var number = begin; number < end;) {
    var piece = piece_at(select(begin + end - 1u - number, number, j > i));
    piece = Piece(piece.width, 0, 0, piece.depth, select(piece.high, piece.low, j > i), select(piece.low, piece.high, j > i));
    let parts = parts_of(rate * piece.depth);
    stretch = joined(stretch, part_of(piece, done, parts, rate));
    done += 1.0;
    if (done == parts) {
      number++;
      done = 0.0;
    }
  }
  return stretch.to_low.light;
}

fn interval(i: u32, j: u32, k: u32) -> u32 { return select(i - 1u - k, i + k, j > i); }

fn intervals(i: u32, j: u32, count: u32, rate: f32) -> vec4f {
  var rgb = vec3f(0.0);
  var through = 1.0;
  for (var k = 0u; k < select(0u, count, params.layer == INTERVALS); k++) {
    let medium = waiting[interval(i, j, k)];
    let passes = exp(-medium.a * rate);
    rgb += through * (1.0 - passes) * medium.rgb;
    through *= passes;
  }
  return vec4f(rgb, 1.0 - through);
}

fn hoisted(i: u32, j: u32, count: u32) -> vec4f {
  var rgb = vec3f(0.0);
  var through = 1.0;
  for (var k = 0u; k < select(0u, count, params.layer == HOISTED); k++) {
    let light = waiting[(count + 1u) * params.entries + interval(i, j, k)];
    rgb += through * light.rgb;
    through *= light.a;
  }
  return vec4f(rgb, 1.0 - through);
}

// What interval `k` sends and lets through in slabs over `m` of them.
fn hoist(k: u32, m: u32) {
  let medium = waiting[k];
  let passes = exp(-medium.a * params.length_world / f32(max(m, 1u)));
  waiting[(m + 1u) * params.entries + k] = vec4f((1.0 - passes) * medium.rgb, passes);
}
