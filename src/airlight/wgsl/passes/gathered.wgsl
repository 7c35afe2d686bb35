// The nearest of the triangles that let light pass at each pixel, put in order: each is set among those that are there.

import generated::frame::frame;
import generated::mesh::params;
import generated::pass::{covers, cover_counts, fragments, fragment_counts};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::cover::{COVER_NUMBERS, Cover};
import package::fragments::{FRONT, fragment_place};
import package::lit_triangle::lit_triangle;
import slot::camera::eye_ray;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let seen = id.xy + params.seen_px;
  if (any(seen >= frame.tile_size_px)) { return; }
  let met = atomicLoad(&fragment_counts[fragment_place(seen, 0u)]);
  if (met > params.layers && params.is_first != 0u) { atomicAdd(&cover_counts[params.layers + 1u], 1u); }
  let count = min(met, frame.fragment_slots);
  // No loop ends by a uniform alone: software devices would compile it anew for each dispatch.
  let layers = min(met, params.layers);
  let pixel = frame.tile_origin_px + seen;
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let ray = eye_ray(vec2f(pixel) + 0.5);
  for (var slot = 0u; slot < count; slot++) {
    let number = (fragments[fragment_place(seen, slot)] & ~FRONT) - params.first_triangle;
    if (number >= params.triangles) { continue; }
    var cover = lit_triangle(number, ray);
    // What lies behind it moves on by one; what was last goes.
    for (var layer = 1u; layer <= layers; layer++) {
      let place = COVER_NUMBERS * (layer * frame.size_px.x * frame.band_rows + at);
      let t_there = covers[place + 4u];
      if (t_there > 0.0 && t_there <= cover.t_world) { continue; }
      let there = Cover(vec3f(covers[place], covers[place + 1u], covers[place + 2u]), covers[place + 3u], t_there);
      covers[place] = cover.rgb.r;
      covers[place + 1u] = cover.rgb.g;
      covers[place + 2u] = cover.rgb.b;
      covers[place + 3u] = cover.alpha;
      covers[place + 4u] = cover.t_world;
      cover = there;
      if (t_there <= 0.0) {
        atomicAdd(&cover_counts[layer], 1u);
        break;
      }
    }
  }
}
