// Where the rays of pixels meet the opaque triangles that were found there, and in which light.

import generated::frame::frame;
import generated::mesh::params;
import generated::pass::{covers, triangles};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::cover::COVER_NUMBERS;
import package::lit_triangle::lit_triangle;
import slot::camera::eye_ray;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let place = id.xy + params.seen_px;
  if (any(place >= frame.tile_size_px)) { return; }
  let found = textureLoad(triangles, place, 0).xy;
  if (found.x == 0u || found.y != params.number) { return; }
  let pixel = frame.tile_origin_px + place;
  let cover = lit_triangle(found.x - 1u, eye_ray(vec2f(pixel) + 0.5));
  let in_band = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let at = COVER_NUMBERS * in_band;
  covers[at] = cover.rgb.r;
  covers[at + 1u] = cover.rgb.g;
  covers[at + 2u] = cover.rgb.b;
  covers[at + 3u] = cover.alpha;
  covers[at + 4u] = cover.t_world;
}
