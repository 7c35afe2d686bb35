// Where a closed mesh that clips begins or ceases to keep a ray: its distance, and the normal there. A pixel has a row of them, the
// nearest first; behind the last comes one at INFINITE, which tells as all do by its own change what is kept before it.

import generated::frame::frame;

struct Change { t_world: f32, about: u32 }

const BEGINS = 0x10000000u;  // something is kept from there on
const CAPPED = 0x20000000u;
const NORMAL_STEPS = 16383.0;

// Place of a change: of each mesh, one slot after the other for all pixels.
fn change_place(list: u32, slot: u32, pixel: u32) -> u32 {
  return (list * frame.change_slots + slot) * frame.size_px.x * frame.band_rows + pixel;
}

// A direction in 28 bits, on the octahedron (Meyer and others 2010).
fn packed_normal(normal: vec3f) -> u32 {
  let p = normal / (abs(normal.x) + abs(normal.y) + abs(normal.z));
  let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p.xy >= vec2f(0.0));
  let place = vec2u(round((0.5 + 0.5 * select(folded, p.xy, p.z >= 0.0)) * NORMAL_STEPS));
  return place.x | (place.y << 14u);
}

fn unpacked_normal(about: u32) -> vec3f {
  let place = vec2f(vec2u(about & 16383u, (about >> 14u) & 16383u)) / NORMAL_STEPS * 2.0 - 1.0;
  let z = 1.0 - abs(place.x) - abs(place.y);
  let folded = (1.0 - abs(place.yx)) * select(vec2f(-1.0), vec2f(1.0), place >= vec2f(0.0));
  return normalize(vec3f(select(folded, place, z >= 0.0), z));
}
