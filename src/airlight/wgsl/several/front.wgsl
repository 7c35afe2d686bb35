// The front of the slabs of all layers with what is known of it.

import next::several::layer::{Knowns, Lights, send};
import package::faces::Face;
import package::optics::mean_transmittance;
import package::ray::Ray;
import package::sample::{Sample, Slab};

struct Front { here: Sample, known: Knowns, light: Lights, is_lit: bool }

struct LitSlab { slab: Slab, lit_rgb: vec3f }

// Thinned and tinted each layer's slab is by itself, and has its own length: of the whole one it matters how much longer it is than
// the way from its front to its back.
fn next_slab(front: ptr<function, Front>, back: Sample, length: f32, tint: vec3f, face: Face, ray: Ray) -> LitSlab {
  let near = (*front).here;
  let way = back.t_world - near.t_world;
  let share = select(1.0, length / way, way > 0.0);
  let sent = send(
    (*front).known, (*front).light, (*front).is_lit, near.value, near.p_world, back.value, back.p_world, share, face.faces, ray,
  );
  (*front).known = sent.knowns;
  (*front).light = sent.lights;
  (*front).is_lit = true;
  let through = mean_transmittance(sent.mixed.depth);
  let rgb = sent.mixed.source * through;
  return LitSlab(Slab(rgb, 0.0, vec3f(0.0), 0.0, sent.mixed.depth * through), rgb);
}
