// Faces that clips leave where they cut several layers.

import next::several::layer::{Faces, caps_of, cuts_of};
import package::ray::Ray;
import package::sample::{Sample, Slab};
import slot::integrate::{Accumulated, take};

struct Face { faces: Faces }

fn face_gradient(number: u32, p_world: vec3f) -> vec3f { return vec3f(0.0); }

fn face_of(number: u32, cut: Sample, ray: Ray) -> Face { return Face(cuts_of(number, cut.value, cut.p_world, cut.t_world, ray)); }

// Where several layers are solid, the face has their mean.
fn take_cap(acc: ptr<function, Accumulated>, cut: Sample, clip: u32, ray: Ray) -> bool {
  let caps = caps_of(clip, cut.value, cut.p_world, cut.t_world, ray);
  let rgb = caps.rgb / max(caps.count, 1.0);
  return caps.count > 0.0 && take(acc, cut, cut, Slab(rgb, 0.0, vec3f(0.0), 0.0, 1.0), rgb, 0.0);
}
