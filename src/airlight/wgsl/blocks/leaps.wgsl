// How far a ray may leap from a block: over all blocks that are nearer than so many. 0 where there is something to be seen.

import generated::field::leaps;
import generated::layer::layer;
import generated::sizes::{BLOCK_VOXELS, MOST_LEAP};

fn leap_of(block: vec3f) -> f32 {
  let told = told_of(block);
  return f32(select(told, 0u, told > MOST_LEAP));
}

// How far one slab may go from a block, through all blocks that are nearer than so many: they have one value. 0 where it may not.
fn even_of(block: vec3f) -> f32 { return f32(max(told_of(block), MOST_LEAP) - MOST_LEAP); }

fn told_of(block: vec3f) -> u32 {
  // The last block along each axis: textures are slow to tell their sizes.
  let last = max(ceil((layer.size - 1.0) / f32(BLOCK_VOXELS)) - 1.0, vec3f(0.0));
  return textureLoad(leaps, vec3i(clamp(block, vec3f(0.0), last)), 0).r;
}
