// A piece of a medium between two values, cut at the function's control points: between these colour and extinction are linear.

import generated::transfer::{ASSOCIATED, WEIGHTED};
import package::optics::{mean_transmittance, moved, over, placed, split};
import package::sample::Slab;
import package::transfer::cells::{ROWS_PER_CELL, Reached, cell_of, row_at};
import package::transfer::function::axis_of_function;
import package::transfer::linear::sums_over;
import package::transfer::straight::{lengths_of, with_ends};

const SEEN_DEPTH = 10.0;  // of a cut: eight nodes integrate it to 4e-5, and what lies deeper sends as little
const OPAQUE = 0.99996;

fn between(s_front: f32, front: Reached, s_back: f32, back: Reached, length: f32) -> Slab {
  let lengths = lengths_of(s_front, front, s_back, back, length);
  return with_ends(front, cut_slab(front.value, back.value, lengths.y), back, lengths);
}

// The cuts between two values of the axis, from the front on, until nothing behind is seen.
fn cut_slab(s_front: f32, s_back: f32, length: f32) -> Slab {
  let axis = axis_of_function();
  let way = s_back - s_front;
  let rises = way > 0.0;
  var row = cell_of(axis, s_front).row - 1u;
  var value = s_front;
  var begin = 0.0;
  var slab = Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);
  loop {
    let head = row_at(axis, row);
    let low = row_at(axis, row + 1u);
    let high = row_at(axis, row + 2u);
    let border = select(head.x, head.y, rises);
    let is_last = select(s_back >= border, s_back <= border, rises);
    let next = select(border, s_back, is_last);
    let end = select((border - s_front) / way, 1.0, is_last);
    let near = mix(low, high, saturate((value - head.x) * head.z));
    let far = mix(low, high, saturate((next - head.x) * head.z));
    slab = over(slab, placed(linear_slab(near, far, (end - begin) * length), begin, end));
    if (is_last || slab.alpha > OPAQUE) { break; }
    value = next;
    begin = end;
    row = select(row - ROWS_PER_CELL, row + ROWS_PER_CELL, rises);
  }
  return slab;
}

// A slab along which colour and extinction are linear.
fn linear_slab(near: vec4f, far: vec4f, length: f32) -> Slab {
  let rise = far - near;
  let depth = length * (near.a + 0.5 * rise.a);
  let alpha = depth * mean_transmittance(depth);
  // Integrate as far as can be seen.
  let seen = SEEN_DEPTH / max(length, 1e-30);
  let reach = min(2.0 * seen / max(near.a + sqrt(max(near.a * near.a + 2.0 * rise.a * seen, 0.0)), 1e-30), 1.0);
  let sums = sums_over(near.a, reach * rise.a, reach * length, 0.0, ASSOCIATED).to_low;
  let rgb = max(near.rgb * select(alpha, sums.x, ASSOCIATED) + rise.rgb * (reach * sums.y), vec3f(0.0));
  let slab = Slab(rgb, alpha, vec3f(0.0), 0.0, alpha);
  if (!WEIGHTED) { return split(slab, vec4f(0.5 - moved(depth))); }
  let moment = reach * vec4f(near.rgb * sums.y + rise.rgb * (reach * sums.z), sums.w);
  return split(slab, saturate(moment / max(vec4f(rgb, alpha), vec4f(1e-30))));
}
