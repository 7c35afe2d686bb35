// What surfaces cut a slab of a medium into: the piece up to the first of them, the run of surfaces, the piece behind the last.

import generated::transfer::params;
import package::optics::thicker;
import package::sample::Slab;
import package::transfer::cells::Reached;
import package::transfer::function::reach;
import package::transfer::straight::{lengths_of, mean_between};
import package::transfer::iso_values::{number_of, reach_surface};
import package::transfer::surfaces::{Crossing, crossing_of, step_on, light_at, moment_at};
import package::transfer::surfaces::{crossed, thinned};

// The surfaces and the medium between them; a cubic runs through the four lengths of the table.
fn run_of(crossing: Crossing, length: f32, thickness: f32) -> Slab {
  let way = (crossing.last - crossing.first) * length;
  let x = 3.0 * saturate(way / params.surface_length);
  let a = vec4f(-(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0, x * (x - 2.0) * (x - 3.0) / 2.0, -x * (x - 1.0) * (x - 3.0) / 2.0, x * (x - 1.0) * (x - 2.0) / 6.0);
  let alone = light_at(crossing, 0u);
  var light = a.x * alone + a.y * light_at(crossing, 1u) + a.z * light_at(crossing, 2u) + a.w * light_at(crossing, 3u);
  let moment = a.x * moment_at(crossing, 0u) + a.y * moment_at(crossing, 1u) + a.z * moment_at(crossing, 2u) + a.w * moment_at(crossing, 3u);
  light = vec4f(max(light.rgb, vec3f(0.0)), 1.0 - (1.0 - alone.a) * exp(-crossing.mean_extinction * way));
  return thinned(crossed(crossing, light, moment), 1.0 - thicker(1.0 - alone.a, thickness) * exp(-crossing.mean_extinction * way));
}

// Optical depth of the medium between two values.
fn depth_between(s_from: f32, from_known: Reached, s_to: f32, to_known: Reached, length: f32) -> f32 {
  let lengths = lengths_of(s_from, from_known, s_to, to_known, length);
  return dot(lengths, vec3f(from_known.here.a, mean_between(from_known, to_known, params.per_value).a, to_known.here.a));
}

// Share of a slab at which its opacity reaches a wanted one: at a surface, or in a piece of the medium, which is homogeneous.
fn share_of_opacity(s_front: f32, s_back: f32, length: f32, thickness: f32, wanted: f32) -> f32 {
  let front = number_of(s_front);
  let back = number_of(s_back);
  let rises = back > front;
  let count = select(front - back, back - front, rises);
  let target_depth = depth_of(wanted);
  let front_known = reach(s_front);
  let back_known = reach(s_back);
  if (count == 0u) {
    return saturate(target_depth / max(depth_between(s_front, front_known, s_back, back_known, length), 1e-30));
  }
  let run = crossing_of(s_front, front, s_back, back);
  let first = select(front - 1u, front, rises);
  let near = depth_between(s_front, front_known, run.first_value, reach_surface(first, !rises), run.first * length);
  // Halve the run until the first surface is found behind which there is enough.
  var low = 0u;
  var high = count;
  while (low < high) {
    let middle = (low + high) / 2u;
    let next = crossing_of(s_front, front, s_back, step_on(front, middle + 1u, rises));
    let enough = near + depth_behind(next, length, thickness) >= target_depth;
    low = select(middle + 1u, low, enough);
    high = select(high, middle, enough);
  }
  // The piece before that surface, or before the back: its ends, and the depths there.
  var begin = 0.0;
  var before = 0.0;
  if (low > 0u) {
    let last = crossing_of(s_front, front, s_back, step_on(front, low, rises));
    begin = last.last;
    before = near + depth_behind(last, length, thickness);
  }
  var end = 1.0;
  var piece = 0.0;
  if (low == count) {
    let last = select(back, back - 1u, rises);
    piece = depth_between(run.last_value, reach_surface(last, rises), s_back, back_known, (1.0 - run.last) * length);
  } else {
    let next = crossing_of(s_front, front, s_back, step_on(front, low + 1u, rises));
    end = next.last;
    let medium_only = near + next.mean_extinction * (next.last - next.first) * length;
    piece = medium_only - before;
    if (low > 0u) { piece += depth_of_surfaces(crossing_of(s_front, front, s_back, step_on(front, low, rises)), thickness); }
  }
  return begin + (end - begin) * saturate((target_depth - before) / max(piece, 1e-30));
}

fn depth_of(alpha: f32) -> f32 { return -log(max(1.0 - alpha, 1e-30)); }

fn depth_of_surfaces(crossing: Crossing, thickness: f32) -> f32 {
  return depth_of(1.0 - thicker(1.0 - light_at(crossing, 0u).a, thickness));
}

// Optical depth from the front-most surface to behind the hindmost.
fn depth_behind(crossing: Crossing, length: f32, thickness: f32) -> f32 {
  let medium = crossing.mean_extinction * (crossing.last - crossing.first) * length;
  return medium + depth_of_surfaces(crossing, thickness);
}
