// A light on its way through a group of slices: each fragment carries on what its own ray of the light lets through, and keeps it at
// each plane for those who look at the group. What is drawn of the group before is carried over as it is, so that two textures in
// turn hold all of the light at the last plane. Planes are written where light has changed: most rays are as bright as they began,
// or dark.

import generated::group::params as group;
import generated::pass::light_before;
import package::met::Met;
import package::on_tile::on_tile;
import package::light_kept::{DARK, UNTOUCHED, light_in};
import package::ray::INFINITE;
import package::slabs::march_part;
import package::walk::{line_of, place_of};
import slot::camera::eye_ray;
import slot::integrate::{begin, keep_until, light_at_end};
import slot::transport::{gathered, lasting};

@vertex
fn at_corner(@location(0) p_world: vec3f) -> @builtin(position) vec4f {
  return on_tile(p_world, group.near_world, group.far_world);
}

@fragment
fn pass_group(@builtin(position) place: vec4f) -> @location(0) vec4f {
  let texel = vec2u(place.xy);
  let before = textureLoad(light_before, texel, 0);
  if (before.a == DARK) { return before; }
  let line = line_of(eye_ray(vec2f(texel) + 0.5), texel);
  var acc = begin();
  acc.light = light_in(before);
  acc.is_new = before.a == UNTOUCHED;
  acc.texel = texel;
  acc.first_world = place_of(line, group.first);
  acc.step_world = line.spacing.step_world;
  let t_begin = max(line.enter, acc.first_world);
  let t_end = min(line.leave, place_of(line, group.last));
  let meets = t_end > t_begin;
  acc.around = gathered(acc.light, line.ray.origin_world + acc.first_world * line.ray.direction_world);
  if (meets && lasting(acc.light)) {
    var covers_taken = 1u;
    var samples = 0.0;
    var met: Met;
    march_part(line, t_begin, t_end, line.at, &acc, &covers_taken, &samples, &met);
  }
  if (!lasting(acc.light)) { acc.through = vec4f(0.0); }
  keep_until(&acc, INFINITE);
  if (!lasting(acc.light)) { return vec4f(vec3f(0.0), DARK); }
  return light_at_end(acc);
}
