// Slices, as far as they are drawn in one pass: each fragment takes the slabs of a group of them that its ray meets.

import generated::driver::BACK_TO_FRONT;
import generated::frame::frame;
import generated::group::params as group;
import generated::pass::unfinished;
import generated::sizes::{FILLS, SKIPS_BLOCKS};
import package::met::Met;
import package::on_tile::on_tile;
import package::slabs::march_part;
import package::unfinished::Unfinished;
import package::walk::{line_of, next_block, place_of};
import slot::camera::eye_ray;
import slot::integrate::{begin, join, pause, resume};

@vertex
fn at_corner(@location(0) p_world: vec3f) -> @builtin(position) vec4f {
  return on_tile(p_world, group.near_world, group.far_world);
}

@fragment
fn take_group(@builtin(position) place: vec4f) {
  let here = vec2u(place.xy);
  let number = here.y * frame.tile_size_px.x + here.x;
  if (unfinished[number].ended != 0u) { return; }
  let pixel = frame.tile_origin_px + here;
  let line = line_of(eye_ray(vec2f(pixel) + 0.5), pixel);
  let t_begin = max(line.enter, place_of(line, group.first));
  let t_end = min(line.leave, place_of(line, group.last));
  if (t_end <= t_begin) { return; }
  // Where all blocks on the way are empty there is nothing to take up.
  if (SKIPS_BLOCKS && !FILLS && next_block(line, t_begin, t_end) >= t_end) { return; }
  var ray = unfinished[number];
  var before = begin();
  if (ray.covers_taken > 0u) { before = resume(ray.paused); }
  var acc = before;
  if (BACK_TO_FRONT) { acc = begin(); }
  var covers_taken = max(ray.covers_taken, 1u);
  var samples = abs(ray.samples);
  var met: Met;
  let stops = march_part(line, t_begin, t_end, line.at, &acc, &covers_taken, &samples, &met);
  if (BACK_TO_FRONT) { acc = join(acc, before); }
  ray.paused = pause(acc);
  ray.samples = select(samples, -abs(samples), min(ray.samples, samples) < 0.0);
  ray.covers_taken = covers_taken;
  ray.ended = u32(stops && !BACK_TO_FRONT);
  unfinished[number] = ray;
}
