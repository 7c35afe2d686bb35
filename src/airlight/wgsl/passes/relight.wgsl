// Light on surfaces that a march has found: see `hits/kept.wgsl`.

import generated::frame::frame;
import generated::layer::layer;
import generated::pass::{radiance, depth, hits};
import generated::sizes::{Values, WORKGROUP_X, WORKGROUP_Y};
import package::lighting::at_share::{lit_by_gradient, lit_whole};
import package::sample::{Sample, Slab};
import slot::camera::eye_ray;
import slot::integrate::surface_rgb;
import slot::region::part_at;
import slot::tone::tone;
import slot::transfer::medium;
import slot::values::with_scalar;

@compute @workgroup_size(WORKGROUP_X, WORKGROUP_Y)
fn main(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= frame.size_px.x || id.y >= frame.band_rows) { return; }
  let at = id.y * frame.size_px.x + id.x;
  let p_px = vec2f(id.xy) + vec2f(0.5, 0.5 + f32(frame.band_first_row));
  let shape = hits[2u * at];
  let place = hits[2u * at + 1u];
  let is_hit = place.y > 0.0;
  let t_world = select(0.0, place.x, is_hit);
  let ray = eye_ray(p_px);
  let p_world = ray.origin_world + t_world * ray.direction_world;
  let p_index = (layer.index_from_world * vec4f(p_world, 1.0)).xyz;
  var value: Values;
  let here = Sample(with_scalar(value, shape.w), shape.xyz, p_index, p_world, t_world);
  var near = here;
  var far = here;
  near.value = with_scalar(value, 0.0);
  far.value = with_scalar(value, select(1.0, -1.0, place.y == 2.0));
  var rgb = medium(here).rgb;
  if (place.y < 3.0) { rgb = surface_rgb(here, near, far, rgb); }
  let slab = Slab(rgb * part_at(p_index).rgb, 1.0, vec3f(0.0), 0.0, 1.0);
  let lit = lit_whole(slab, lit_by_gradient(here, ray));
  radiance[at] = select(vec4f(0.0), vec4f(tone(lit, p_px), 1.0), is_hit);
  depth[at] = vec2f(place.x + frame.t_offset_world, 0.0);
}
