// The surface at which a ray through several layers ends: the nearest in the first slab that holds one.

import next::several::hits::{hit_at, nearest};
import package::faces::Face;
import package::kept::Kept;
import package::met::Met;
import package::sample::{Sample, Slab};
import package::walk::Line;
import slot::integrate::{Accumulated, take};

fn shown_surface(front: Sample, back: Sample) -> vec2f {
  return vec2f(nearest(front.value, front.p_world, back.value, back.p_world), 0.0);
}

fn take_surface(
  acc: ptr<function, Accumulated>, line: Line, front: Sample, back: Sample, shown: vec2f, kept: Kept, face: Face,
) -> Met {
  let hit = hit_at(line.lines, front.value, front.p_world, back.value, back.p_world, kept, face.faces);
  var here = front;
  here.t_world = hit.t_world;
  take(acc, here, here, Slab(hit.rgb, 0.0, vec3f(0.0), 0.0, hit.alpha), hit.rgb, 0.0);
  return hit.met;
}
