// How far a ray may leap from a block: over all blocks that are nearer than so many. 0 where there is something to be seen.

import generated::field::leaps;

fn leap_of(block: vec3f) -> f32 {
  let last = vec3f(textureDimensions(leaps)) - 1.0;
  return f32(textureLoad(leaps, vec3i(clamp(block, vec3f(0.0), last)), 0).r);
}
