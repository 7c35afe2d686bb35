// What rays meet of meshes, as `passes/covers.wgsl` left it: the nearest opaque one, number 0, and from 1 on those before it that
// let light pass, the nearest first.

import generated::frame::frame;
import generated::pass::covers;
import package::cover::{COVER_NUMBERS, Cover, NO_COVER};

const HAS_COVERS = true;

fn cover_at(pixel: u32, number: u32) -> Cover {
  if (number > frame.cover_count) { return NO_COVER; }
  let at = COVER_NUMBERS * (number * frame.size_px.x * frame.band_rows + pixel);
  if (covers[at + 4u] <= 0.0) { return NO_COVER; }
  return Cover(vec3f(covers[at], covers[at + 1u], covers[at + 2u]), covers[at + 3u], covers[at + 4u]);
}
