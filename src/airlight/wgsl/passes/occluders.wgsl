// What hides, at a low resolution: the optical depth of cells of voxels, by the mean of what their parts let through, by colour.
//
// A part is what lies at a voxel: the slabs towards its next neighbours, so that nothing between two voxels is missed.

import generated::layer::layer;
import generated::occlusion::params as occlusion;
import generated::pass::occluders_out;
import generated::slice::params as slice;
import package::sample::Sample;
import package::transport::colours::colour_of;
import slot::clips::is_kept;
import slot::field::{locate, field_value};
import slot::region::part_at;
import slot::transfer::{know, classify_known};
import slot::values::is_gap;

const LEAST_THROUGH: f32 = 1e-4;

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let cell = vec3u(id.xy, id.z + slice.first_z);
  if (any(cell >= occlusion.cells)) { return; }
  let low = cell * occlusion.block;
  let size = vec3u(layer.size);
  let high = min(low + occlusion.block, size);
  var opacity = vec3f(0.0);
  for (var z = low.z; z < high.z; z++) {
    for (var y = low.y; y < high.y; y++) {
      for (var x = low.x; x < high.x; x++) { opacity += 1.0 - exp(-extinction_at(vec3u(x, y, z), size) * occlusion.cell_world); }
    }
  }
  let count = high - low;  // the last cells along an axis may have fewer voxels than others, and end with them
  let depth = -log(max(1.0 - opacity / f32(count.x * count.y * count.z), vec3f(LEAST_THROUGH)));
  textureStore(occluders_out, cell, vec4f(depth, 0.0));
}

// Mean extinction [1/world] of the slabs from a voxel to the next along each axis; there is none where the voxel is empty. With a
// tint it is less for light of the slab's own colour.
fn extinction_at(voxel: vec3u, size: vec3u) -> vec3f {
  let front = voxel_sample(voxel);
  if (is_gap(front.value) || !is_kept(front.p_index)) { return vec3f(0.0); }
  let known = know(front);
  let part = part_at(front.p_index);
  var sum = vec3f(0.0);
  for (var axis = 0u; axis < 3u; axis++) {
    var next = voxel;
    next[axis] = min(voxel[axis] + 1u, size[axis] - 1u);
    var back = voxel_sample(next);
    if (is_gap(back.value)) { back = front; }
    let length = occlusion.spacing[axis];
    let slab = classify_known(front, known, back, know(back), length * part.opacity);
    sum -= (1.0 - occlusion.tint * part.rgb * colour_of(slab)) * (log(max(1.0 - slab.alpha, 1e-7)) / length);
  }
  return sum / 3.0;
}

fn voxel_sample(voxel: vec3u) -> Sample {
  let p_index = vec3f(voxel);
  return Sample(field_value(locate(p_index)), vec3f(0.0), p_index, vec3f(0.0), 0.0);
}
