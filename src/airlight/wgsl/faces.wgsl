// Faces that clips leave where they cut. They are lit by the clip's normal, since the gradient there belongs to what is cut away as
// well, and what lies behind them is lit so, too, less and less over the depth of a skin (Weiskopf, Engel and Ertl 2003).

import generated::frame::frame;
import generated::sizes::{CLASSIFIES, LIGHTS_FACES, SURFACES_ONLY};
import package::lighting::at_share::{lit_by_gradient, lit_whole};
import package::optics::tinted;
import package::ray::Ray;
import package::sample::{Lit, Sample, Slab};
import package::walk::Line;
import slot::clips::{cut_normal, is_capped};
import slot::integrate::{Accumulated, take};
import slot::region::part_at;
import slot::transfer::{know, classify_known};
import slot::values::is_gap;

struct Face {
  lit: Lit,
  share: f32,    // of this light in that of what lies right behind
  t_world: f32,
}

// Long enough to mean a surface in any data.
const STEEP = 1e30;
// Opacity of a skin from which on it is solid where a clip is capped.
const LEAST_SOLID = 1e-3;

// Gradient at the face of a clip, which has a number from 1 on.
fn face_gradient(number: u32, p_world: vec3f) -> vec3f { return -STEEP * cut_normal(max(number, 1u), p_world); }

// How a cut is lit. What is thin there has no face: the share is the opacity of a skin filled with what lies at the cut.
fn face_of(number: u32, cut: Sample, ray: Ray) -> Face {
  var here = cut;
  here.gradient = face_gradient(number, cut.p_world);
  var share = 1.0;
  if (CLASSIFIES) { share = filled(cut).alpha; }
  return Face(lit_by_gradient(here, ray), select(share, 0.0, number == 0u || is_gap(cut.value)), cut.t_world);
}

// Light of a slab that has another by itself, where it lies behind a face.
fn lit_behind(face: Face, slab: Slab, front: Sample, back: Sample, lit_rgb: vec3f) -> vec3f {
  let behind = 0.5 * (front.t_world + back.t_world) - face.t_world;
  var share = face.share * saturate(1.0 - behind / frame.skin_world);
  if (SURFACES_ONLY) { share = select(0.0, face.share, behind <= 0.0); }
  return mix(lit_rgb, lit_whole(slab, face.lit), share);
}

// Of several layers some have faces of clips that cut them alone.
fn own_faces(face: Face, line: Line, cut: Sample) -> Face { return face; }

fn take_own_caps(acc: ptr<function, Accumulated>, line: Line, cut: Sample) -> bool { return false; }

// The solid face of a clip, as a slab without length. Whether the ray ends there.
fn take_cap(acc: ptr<function, Accumulated>, cut: Sample, clip: u32, ray: Ray) -> bool {
  let cap = cap_of(clip, cut);
  return cap.alpha > 0.0 && take(acc, cut, cut, cap, lit_cap(cap, clip, cut, ray), 0.0);
}

// The solid face of a capped clip, in the colour that endless depth of what lies at the cut has; empty where nothing does.
fn cap_of(number: u32, cut: Sample) -> Slab {
  let layer = filled(cut);
  let is_solid = is_capped(number) && layer.alpha >= LEAST_SOLID && !is_gap(cut.value);
  let rgb = (layer.front_rgb + layer.back_rgb) / max(layer.alpha, 1e-30);
  return Slab(rgb * f32(is_solid), f32(is_solid), vec3f(0.0), 0.0, f32(is_solid));
}

fn lit_cap(cap: Slab, number: u32, cut: Sample, ray: Ray) -> vec3f {
  if (!LIGHTS_FACES) { return cap.front_rgb; }
  return lit_whole(cap, face_of(number, cut, ray).lit);
}

fn filled(cut: Sample) -> Slab {
  let known = know(cut);
  let part = part_at(cut.p_index);
  return tinted(classify_known(cut, known, cut, known, frame.skin_world * part.opacity), part.rgb);
}
