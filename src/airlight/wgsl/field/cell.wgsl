// The cell of eight voxels round a place, or the cell below it on the upper faces of the grid: what trilinear interpolation takes.

import generated::layer::layer;
import slot::taps::{PARTS, Tap, slope_of_sum, tap};

struct Corners { low: vec3i, high: vec3i, share: vec3f }

fn corners_at(p_index: vec3f) -> Corners {
  let last = layer.size - 1.0;
  let p = clamp(p_index, vec3f(0.0), last);
  let low = min(floor(p), max(last - 1.0, vec3f(0.0)));
  return Corners(vec3i(low), vec3i(min(low + 1.0, last)), p - low);
}

fn cell_sum(corners: Corners, part: u32) -> Tap {
  let a = corners.low;
  let b = corners.high;
  let x00 = mixed_taps(tap(vec3i(a.x, a.y, a.z), part), tap(vec3i(b.x, a.y, a.z), part), corners.share.x);
  let x10 = mixed_taps(tap(vec3i(a.x, b.y, a.z), part), tap(vec3i(b.x, b.y, a.z), part), corners.share.x);
  let x01 = mixed_taps(tap(vec3i(a.x, a.y, b.z), part), tap(vec3i(b.x, a.y, b.z), part), corners.share.x);
  let x11 = mixed_taps(tap(vec3i(a.x, b.y, b.z), part), tap(vec3i(b.x, b.y, b.z), part), corners.share.x);
  return mixed_taps(mixed_taps(x00, x10, corners.share.y), mixed_taps(x01, x11, corners.share.y), corners.share.z);
}

// The derivative of trilinear interpolation [data/voxel].
fn cell_derivative(p_index: vec3f) -> vec3f {
  let corners = corners_at(p_index);
  let a = corners.low;
  let b = corners.high;
  var found = vec3f(0.0);
  for (var part = 0u; part < PARTS; part++) {
    // The eight voxels: low or high along x, y and z.
    let lll = tap(vec3i(a.x, a.y, a.z), part);
    let hll = tap(vec3i(b.x, a.y, a.z), part);
    let lhl = tap(vec3i(a.x, b.y, a.z), part);
    let hhl = tap(vec3i(b.x, b.y, a.z), part);
    let llh = tap(vec3i(a.x, a.y, b.z), part);
    let hlh = tap(vec3i(b.x, a.y, b.z), part);
    let lhh = tap(vec3i(a.x, b.y, b.z), part);
    let hhh = tap(vec3i(b.x, b.y, b.z), part);
    // What is between along x, on the four edges.
    let ll = mixed_taps(lll, hll, corners.share.x);
    let hl = mixed_taps(lhl, hhl, corners.share.x);
    let lh = mixed_taps(llh, hlh, corners.share.x);
    let hh = mixed_taps(lhh, hhh, corners.share.x);
    let low_x = mixed_taps(hll - lll, hhl - lhl, corners.share.y);
    let high_x = mixed_taps(hlh - llh, hhh - lhh, corners.share.y);
    let along_x = mixed_taps(low_x, high_x, corners.share.z);
    let along_y = mixed_taps(hl - ll, hh - lh, corners.share.z);
    let along_z = mixed_taps(lh - ll, hh - hl, corners.share.y);
    let sum = mixed_taps(mixed_taps(ll, hl, corners.share.y), mixed_taps(lh, hh, corners.share.y), corners.share.z);
    found += vec3f(slope_of_sum(sum, along_x, part), slope_of_sum(sum, along_y, part), slope_of_sum(sum, along_z, part));
  }
  return found;
}

fn mixed_taps(a: Tap, b: Tap, share: f32) -> Tap { return a * (1.0 - share) + b * share; }
