// What slabs let through by colour.

import package::optics::thicker;
import package::sample::Slab;

// The mean colour of a slab, at most 1.
fn colour_of(slab: Slab) -> vec3f { return saturate((slab.front_rgb + slab.back_rgb) / max(slab.alpha, 1e-12)); }

// By a share of extinction that is less the more a slab has of a colour: slabs in a row let through what one does.
fn let_through(slab: Slab, share: f32) -> vec3f {
  let thickness = 1.0 - share * colour_of(slab);
  let through = 1.0 - slab.alpha;
  return vec3f(thicker(through, thickness.r), thicker(through, thickness.g), thicker(through, thickness.b));
}
