// The voxels round a place that a filter gives weight to.

import generated::layer::layer;
import slot::taps::{Tap, tap};

// The first of them along each axis, the last voxel of the grid, and the share of the way from the voxel below the place on.
struct Around { first: vec3i, last: vec3i, share: vec3f }

fn around(p_index: vec3f, radius: i32) -> Around {
  let low = floor(p_index);
  return Around(vec3i(low) + 1 - radius, vec3i(layer.size) - 1, p_index - low);
}

// The voxel that lies steps from the first; beyond the faces of the grid the outer one.
fn tap_at(here: Around, steps: vec3i, part: u32) -> Tap { return tap(clamp(here.first + steps, vec3i(0), here.last), part); }
