// The surface of a layer in a slab, and those of the layers behind it in the list: the nearest is met.

import next::several::hits::{hit_at as rest_hit_at, nearest as rest_nearest};
import package::kept::Kept;
import package::several::ends::{FilledEnds, filled_ends, sample_here};
import package::several::hits_end::Hit;
import package::several::layer::{Faces, Fetches, Lines};
import slot::integrate::{begin, finish};
import slot::met::{shown_surface, take_surface};

// The share of the slab at which the first surface lies, 2 where there is none.
fn nearest(front: Fetches, p_front: vec3f, back: Fetches, p_back: vec3f) -> f32 {
  let ends = filled_ends(sample_here(front.own, p_front), sample_here(back.own, p_back));
  return min(own_share(front, back, ends), rest_nearest(front.rest, p_front, back.rest, p_back));
}

fn own_share(front: Fetches, back: Fetches, ends: FilledEnds) -> f32 {
  let is_there = ends.share > 0.0 && back.own.t_world > front.own.t_world;
  return select(2.0, shown_surface(ends.front, ends.back).x, is_there);
}

// What is seen of the nearest one.
fn hit_at(lines: Lines, front: Fetches, p_front: vec3f, back: Fetches, p_back: vec3f, kept: Kept, faces: Faces) -> Hit {
  let ends = filled_ends(sample_here(front.own, p_front), sample_here(back.own, p_back));
  if (own_share(front, back, ends) > rest_nearest(front.rest, p_front, back.rest, p_back)) {
    var behind = rest_hit_at(lines.rest, front.rest, p_front, back.rest, p_back, kept, faces.rest);
    behind.met.layer += 1u;
    return behind;
  }
  var acc = begin();
  let shown = shown_surface(ends.front, ends.back);
  let met = take_surface(&acc, lines.own, ends.front, ends.back, shown, kept, faces.own);
  let result = finish(acc);
  return Hit(result.rgb, result.alpha, result.t_world, met);
}
