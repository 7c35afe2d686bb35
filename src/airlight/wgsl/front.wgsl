// The front of a slab with what is known of it, and the light of slabs: the back of one is the front of the next.

import generated::sizes::{LIGHTS_ENDS, LIGHTS_FACES};
import package::faces::{Face, lit_behind};
import package::optics::tinted;
import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::lighting::{light_slab, LitEnd, know_light, light_known};
import slot::transfer::{Known, classify_known, know};

struct Front {
  here: Sample,
  known: Known,
  light: LitEnd,  // where lighting asks for how ends are lit,
  is_lit: bool,   // and whether it is known
}

struct LitSlab { slab: Slab, lit_rgb: vec3f }

// The slab from the front to a sample, of which the front then knows what is known of the sample.
fn next_slab(front: ptr<function, Front>, back: Sample, length: f32, tint: vec3f, face: Face, ray: Ray) -> LitSlab {
  let back_known = know(back);
  let slab = tinted(classify_known((*front).here, (*front).known, back, back_known, length), tint);
  (*front).known = back_known;
  return LitSlab(slab, lit_slab(front, back, slab, face, ray));
}

fn lit_slab(front: ptr<function, Front>, back: Sample, slab: Slab, face: Face, ray: Ray) -> vec3f {
  let near = (*front).here;
  let shines = slab.alpha > 0.0 || any(slab.front_rgb + slab.back_rgb > vec3f(0.0));
  var lit_rgb = vec3f(0.0);
  if (shines && !LIGHTS_ENDS) { lit_rgb = light_slab(near, back, slab, ray); }
  if (shines && LIGHTS_ENDS) {
    // The front, where it is not known how it is lit, then the back: a loop, since wide processors run both sides of an `if`.
    var end = near;
    if ((*front).is_lit) { end = back; }
    var end_light: LitEnd;
    loop {
      end_light = know_light(end, ray);
      if ((*front).is_lit) { break; }
      (*front).light = end_light;
      (*front).is_lit = true;
      end = back;
    }
    lit_rgb = light_known(near, (*front).light, back, end_light, slab, ray);
    (*front).light = end_light;
  }
  (*front).is_lit = shines;
  if (LIGHTS_FACES) { return lit_behind(face, slab, near, back, lit_rgb); }
  return lit_rgb;
}

// A surface inside a slab, as a slab without length. It becomes the front of what is behind it.
fn lit_sheet(front: ptr<function, Front>, hit: Sample, slab: Slab, ray: Ray) -> vec3f {
  (*front).here = hit;
  (*front).is_lit = true;
  if (!LIGHTS_ENDS) { return light_slab(hit, hit, slab, ray); }
  let light = know_light(hit, ray);
  (*front).light = light;
  return light_known(hit, light, hit, light, slab, ray);
}
