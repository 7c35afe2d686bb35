// Faces that clips leave where they cut several layers.

import next::several::layer::{Faces, caps_of, cuts_of, own_caps_of, own_cuts_of};
import package::ray::Ray;
import package::sample::{Sample, Slab};
import package::several::mixing::Caps;
import package::walk::Line;
import slot::integrate::{Accumulated, take};

struct Face { faces: Faces }

fn face_gradient(number: u32, p_world: vec3f) -> vec3f { return vec3f(0.0); }

fn face_of(number: u32, cut: Sample, ray: Ray) -> Face { return Face(cuts_of(number, cut.value, cut.p_world, cut.t_world, ray)); }

// Clips that cut a layer alone.
fn own_faces(face: Face, line: Line, cut: Sample) -> Face {
  return Face(own_cuts_of(face.faces, line.lines, cut.value, cut.p_world, cut.t_world, line.ray));
}

fn take_own_caps(acc: ptr<function, Accumulated>, line: Line, cut: Sample) -> bool {
  return take_caps(acc, cut, own_caps_of(line.lines, cut.value, cut.p_world, cut.t_world, line.ray));
}

// Where several layers are solid, the face has their mean.
fn take_cap(acc: ptr<function, Accumulated>, cut: Sample, clip: u32, ray: Ray) -> bool {
  return take_caps(acc, cut, caps_of(clip, cut.value, cut.p_world, cut.t_world, ray));
}

fn take_caps(acc: ptr<function, Accumulated>, cut: Sample, caps: Caps) -> bool {
  let rgb = caps.rgb / max(caps.count, 1.0);
  return caps.count > 0.0 && take(acc, cut, cut, Slab(rgb, 0.0, vec3f(0.0), 0.0, 1.0), rgb, 0.0);
}
