// Where rays pass the surface of a closed mesh, put in order: changes of what it keeps. Inside is where more of its surfaces were
// entered than left; all that are entered are left again, which tells whether the eye is inside.

import generated::frame::frame;
import generated::mesh::params;
import generated::outline::params as outline;
import generated::pass::{changes, fragments, fragment_counts, fragment_times};
import generated::sizes::{WORKGROUP_X, WORKGROUP_Y};
import package::fragments::{FRONT, fragment_place};
import package::outline::{BEGINS, CAPPED, change_place, packed_normal};
import package::ray::INFINITE;
import package::triangle::{normal_of, point_of, shares_of, triangle_of};
import slot::camera::eye_ray;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let seen = id.xy + params.seen_px;
  if (any(seen >= frame.tile_size_px)) { return; }
  let met = atomicLoad(&fragment_counts[fragment_place(seen, 0u)]);
  let count = min(met, frame.fragment_slots);
  let pixel = frame.tile_origin_px + seen;
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  let ray = eye_ray(vec2f(pixel) + 0.5);
  var depth = 0;
  for (var slot = 0u; slot < count; slot++) {
    let place = fragment_place(seen, slot);
    let triangle = triangle_of((fragments[place] & ~FRONT) - params.first_triangle);
    let p_world = point_of(triangle, shares_of(triangle, ray));
    fragment_times[place] = dot(p_world - ray.origin_world, ray.direction_world);
    depth -= way_in(fragments[place]);
  }
  // What is left more often than it is entered, the eye is in.
  let keeps_inside = outline.keeps_inside != 0u;
  let all = outline.cuts == 0u;
  // Of rays that are cut in front or behind alone one change counts: the first way in, or the last way out.
  let by_first = (outline.cuts == 1u) == keeps_inside;
  var is_kept = select(select(true, keeps_inside, by_first && depth > 0), (depth > 0) == keeps_inside, all);
  let decided = !all && by_first && depth > 0;
  var written = 0u;
  var last = -1.0;
  var last_slot = 0u;
  for (var turn = 0u; turn < count; turn++) {
    // The next behind the last, by distance and then by slot.
    var next = INFINITE;
    var next_slot = 0u;
    for (var slot = 0u; slot < count; slot++) {
      let t_world = fragment_times[fragment_place(seen, slot)];
      let is_behind = t_world > last || (t_world == last && slot > last_slot);
      if (is_behind && t_world < next) {
        next = t_world;
        next_slot = slot;
      }
    }
    last = next;
    last_slot = next_slot;
    let fragment = fragments[fragment_place(seen, next_slot)];
    let before = depth > 0;
    depth += way_in(fragment);
    let inside = depth > 0;
    let counts = all || (by_first && written == 0u && !decided && inside) || (!by_first && !inside);
    if (inside != before && counts) {
      written = select(written, 0u, !all);
      is_kept = inside == keeps_inside;
      let triangle = triangle_of((fragment & ~FRONT) - params.first_triangle);
      // Out of what is kept.
      let sign = outline.faces_out * select(-1.0, 1.0, keeps_inside);
      let about = packed_normal(sign * normal_of(triangle, shares_of(triangle, ray)));
      let place = change_place(outline.list, written, at);
      changes[place] = vec2u(bitcast<u32>(next), about | select(0u, BEGINS, is_kept) | select(0u, CAPPED, outline.capped != 0u));
      written++;
    }
  }
  changes[change_place(outline.list, written, at)] = vec2u(bitcast<u32>(INFINITE), select(BEGINS, 0u, is_kept));
}

// How many more surfaces a ray is in behind a triangle.
fn way_in(fragment: u32) -> i32 {
  let sees_front = (fragment & FRONT) != 0u;
  return select(-1, 1, sees_front == (outline.faces_out > 0.0));
}
