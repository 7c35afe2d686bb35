// What was marched among the meshes in front of it and behind it.

import generated::sizes::SURFACES_ONLY;
import package::cover::result_over;
import package::ray::INFINITE;
import package::sample::Result;
import slot::covers::{HAS_COVERS, cover_at};

// What is seen of meshes, beside those in front of which the ray has not gone on: in front of a surface that was hit, and behind all.
fn covered(marched: Result, at: u32, first: u32) -> Result {
  if (!HAS_COVERS) { return marched; }
  var number = first;
  var seen = marched;
  if (SURFACES_ONLY) {
    seen = Result(vec3f(0.0), 0.0, INFINITE);
    loop {
      let cover = cover_at(at, number);
      if (cover.t_world >= marched.t_world) { break; }
      seen = result_over(seen, Result(cover.rgb, cover.alpha, cover.t_world));
      number++;
    }
    seen = result_over(seen, marched);
  }
  loop {
    let cover = cover_at(at, number);
    if (cover.t_world >= INFINITE) { break; }
    seen = result_over(seen, Result(cover.rgb, cover.alpha, cover.t_world));
    number++;
  }
  let last = cover_at(at, 0u);
  return result_over(seen, Result(last.rgb, last.alpha, last.t_world));
}
