// What attenuation inside a slab does to its light, for all pairs of entries: incremental subrange integration (Lum, Wilson
// and Ma, sections 4.2 and 4.3), one thread a diagonal, more where diagonals are cut into many blocks.
//
// A slab over m segments has the m-th part of its length in each, so that all windows of a diagonal share the light of single
// segments. These are cut into blocks of m: a window is the end of a block and the beginning of the next, and both grow piece
// by piece. Ends of blocks wait until the beginnings come.

import generated::pass::{waiting, slab_table_out};
import generated::sizes::{WEIGHTED, WORKGROUP_X, WORKGROUP_Y};
import generated::slab_table::params;
import package::optics::{mean_transmittance, moved};
import package::transfer::kept::LEAST_MOVE;
import package::transfer::stretch::{Stretch, Sent, nothing, joined};
import package::transfer::stretch::{piece_at, first_piece, parts_of, part_of, extinction_at, mean_between};

const FEW = 32u;

// Workgroups run through the blocks first: a software adapter gives each core a run of neighbouring groups, and the first
// threads of a diagonal have the most to do.
@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(
  @builtin(workgroup_id) group: vec3u,
  @builtin(local_invocation_id) local: vec3u,
  @builtin(num_workgroups) groups: vec3u,
) {
  let column = group.y * WORKGROUP_X + local.x;
  let thread = group.x * WORKGROUP_Y + local.y;
  let threads = groups.x * WORKGROUP_Y;
  let m = params.first_diagonal + column;
  if (column >= params.diagonals || m >= params.entries) { return; }
  if (m == 0u) {
    for (var i = thread; i < params.entries; i += threads) { write_homogeneous(i); }
    return;
  }
  let desk = thread * m * pitch() + column;
  for (var first = thread * m; first + m < params.entries; first += threads * m) { fill_block(m, first, desk); }
}

// Windows of `m` segments that begin in the block from entry `first` on.
fn fill_block(m: u32, first: u32, desk: u32) {
  let rate = params.length_world / f32(m);
  let next = first + m;
  let last = min(next, params.entries - m) - 1u;
  let middle = first_piece(next);
  let begin = first_piece(first);
  let end = first_piece(last + m);
  // Parts are joined to a few others before they join all: a thousand small numbers are not rounded as one large one is.
  var stretch = nothing();
  var few = nothing();
  var count = 0u;
  var done = 0.0;
  for (var number = middle; number > begin;) {
    let piece = piece_at(number - 1u);
    let parts = parts_of(rate * piece.depth);
    done += 1.0;
    few = joined(part_of(piece, parts - done, parts, rate), few);
    let both = joined(few, stretch);
    if (done == parts) {
      number--;
      done = 0.0;
      let low = u32(max(piece.low_entry, 0));
      if (low > first && low <= last) { keep(desk, low - first, both); }
    }
    count++;
    if (count % FEW == 0u) {
      stretch = both;
      few = nothing();
    }
  }
  finish(first, next, joined(few, stretch));
  stretch = nothing();
  few = nothing();
  count = 0u;
  for (var number = middle; number < end;) {
    let piece = piece_at(number);
    let parts = parts_of(rate * piece.depth);
    few = joined(few, part_of(piece, done, parts, rate));
    let both = joined(stretch, few);
    done += 1.0;
    if (done == parts) {
      number++;
      done = 0.0;
      if (piece.high_entry >= 0) {
        let high = u32(piece.high_entry);
        let low = high - m;
        finish(low, high, joined(kept(desk, low - first, f32(next - low)), both));
      }
    }
    count++;
    if (count % FEW == 0u) {
      stretch = both;
      few = nothing();
    }
  }
}

// What waits lies side by side for neighbouring diagonals; all threads of a diagonal have room for a block.
fn pitch() -> u32 { return params.diagonals + 1u; }

fn keep(desk: u32, offset: u32, stretch: Stretch) {
  let plane = params.entries * pitch();
  let at = desk + offset * pitch();
  waiting[at] = stretch.to_low.light;
  waiting[at + plane] = vec4f(stretch.to_high.light.rgb, stretch.through);
  if (WEIGHTED) {
    waiting[at + 2u * plane] = stretch.to_low.moment;
    waiting[at + 3u * plane] = stretch.to_high.moment;
  }
}

fn kept(desk: u32, offset: u32, width: f32) -> Stretch {
  let plane = params.entries * pitch();
  let at = desk + offset * pitch();
  let low = waiting[at];
  let high = waiting[at + plane];
  // As much white light leaves at either end.
  var stretch = Stretch(width, high.a, Sent(low, vec4f(0.0)), Sent(vec4f(high.rgb, low.a), vec4f(0.0)));
  if (WEIGHTED) {
    stretch.to_low.moment = waiting[at + 2u * plane];
    stretch.to_high.moment = waiting[at + 3u * plane];
  }
  return stretch;
}

// What the table holds: by how much attenuation shifts the mean source, as a multiple of how far it moves light, with mean
// extinction beside it; and the shares of the back.
fn finish(low: u32, high: u32, stretch: Stretch) {
  let mean = mean_between(low, high);
  let depth = mean.a * params.length_world;
  let per_length = 1.0 / (params.length_world * mean_transmittance(depth));
  let middle = 0.5 - moved(depth);
  let per_move = 1.0 / max(0.5 - middle, LEAST_MOVE);
  store(low, high, 0u, vec4f((stretch.to_low.light.rgb * per_length - mean.rgb) * per_move, mean.a));
  store(high, low, 0u, vec4f((stretch.to_high.light.rgb * per_length - mean.rgb) * per_move, mean.a));
  if (WEIGHTED) {
    store(low, high, 1u, back_share(stretch.to_low, stretch.width, middle));
    store(high, low, 1u, back_share(stretch.to_high, stretch.width, middle));
  }
}

// Column front, row back, layer the length; the second plane lies behind all lengths of the first.
fn store(front: u32, back: u32, plane: u32, texel: vec4f) {
  textureStore(slab_table_out, vec2u(front, back), params.layer + plane * params.lengths, texel);
}

// Mean place of what is sent as a share of the way to the back. Where there is no light it is that in a homogeneous medium.
fn back_share(sent: Sent, width: f32, homogeneous: f32) -> vec4f {
  let share = sent.moment / max(width * sent.light, vec4f(1e-37));
  return saturate(select(share, vec4f(homogeneous), sent.light <= vec4f(1e-30)));
}

fn write_homogeneous(i: u32) {
  let extinction = extinction_at(i);
  store(i, i, 0u, vec4f(vec3f(0.0), extinction));
  if (WEIGHTED) { store(i, i, 1u, vec4f(0.5 - moved(extinction * params.length_world))); }
}
