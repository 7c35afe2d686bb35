// The greatest values that the field takes in a block and in a group of blocks, or the least: those that may change what is looked
// for.

import generated::field::bounds;

fn bounds_of(block: vec3f) -> vec2f {
  let last = vec3f(textureDimensions(bounds)) - 1.0;
  return textureLoad(bounds, vec3i(clamp(block, vec3f(0.0), last)), 0).rg;
}

// None is passed over whatever has been found.
fn leap_of(block: vec3f) -> f32 { return 0.0; }

// None is known to have one value.
fn even_of(block: vec3f) -> f32 { return 0.0; }
