// What a texel of the light's buffer holds between two groups of slices: light, or in its last channel a mark.

import generated::lamp::params as lamp;

const UNTOUCHED = -1.0;  // no pass has drawn it: all of the light is there, and nothing is written of planes
const DARK = -2.0;       // no light is left, and all planes tell so

fn light_in(texel: vec4f) -> vec4f {
  return select(select(texel, lamp.begins, texel.a == UNTOUCHED), vec4f(0.0), texel.a == DARK);
}
