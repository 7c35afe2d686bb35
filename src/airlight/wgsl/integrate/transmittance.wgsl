// What comes through along a ray of a light, kept at each plane that it passes. What one ray keeps lies side by side in memory.

import generated::integrate::GREY;
import generated::lamp::params as lamp;
import generated::pass::light_planes_out;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::transport::{Gathered, carried, passing};

// Light at the first plane and what is gathered round it; the place of that plane on the ray, and the next one that is not kept yet.
// `kept`: what the next texel holds, where one holds the light at several planes.
struct Accumulated {
  through: vec4f,
  light: vec4f,
  around: Gathered,
  texel: vec2u,
  is_new: bool,
  next: u32,
  kept: vec4f,
  first_world: f32,
  step_world: f32,
}

const FAINT = vec4f(1e-4);
const TOUCHES = 0.01;  // of the way between two planes

fn begin() -> Accumulated {
  var nothing: Accumulated;
  nothing.through = vec4f(1.0);
  return nothing;
}

fn take(acc: ptr<function, Accumulated>, front: Sample, back: Sample, slab: Slab, lit_rgb: vec3f, length: f32) -> bool {
  keep_until(acc, front.t_world);
  (*acc).through *= passing(slab);
  return all((*acc).light * (*acc).through <= FAINT);
}

// Keep the light at all planes up to a distance.
fn keep_until(acc: ptr<function, Accumulated>, t_world: f32) {
  let count = last_plane() + 1u;
  let passed = u32(clamp(floor((t_world - (*acc).first_world) / (*acc).step_world + TOUCHES) + 1.0, 0.0, f32(count)));
  // Where nothing has changed to the last plane, planes are as they were first written.
  let is_same = !(*acc).is_new && all(light_at_end(*acc) == lamp.begins);
  if (GREY && (*acc).next == 0u) { (*acc).kept = (*acc).light; }
  if (is_same) { (*acc).next = max((*acc).next, passed); }
  if (GREY) { keep_threes(acc, passed); } else { keep_each(acc, passed); }
}

fn keep_each(acc: ptr<function, Accumulated>, passed: u32) {
  loop {
    let next = (*acc).next;
    if (next >= passed) { break; }
    keep(*acc, next, light_behind(*acc, next));
    (*acc).next = next + 1u;
  }
}

// A texel holds the light at three planes, and at that before them.
fn keep_threes(acc: ptr<function, Accumulated>, passed: u32) {
  let light = light_at_end(*acc);
  loop {
    let next = (*acc).next;
    if (next >= passed) { break; }
    let texel = (max(next, 1u) - 1u) / 3u;
    (*acc).kept = select((*acc).kept, light, vec4u(0u, 1u, 2u, 3u) >= vec4u(next - 3u * texel));
    if (passed <= 3u * texel + 3u) {
      (*acc).next = passed;
      break;
    }
    keep(*acc, texel, (*acc).kept);
    (*acc).kept = light;
    (*acc).next = 3u * texel + 4u;
  }
}

fn keep(acc: Accumulated, texel: u32, light: vec4f) {
  if (acc.is_new || any(light != lamp.begins)) { textureStore(light_planes_out, vec3u(texel, acc.texel), light); }
}

fn last_plane() -> u32 {
  let texels = textureDimensions(light_planes_out).x;
  return select(texels - 1u, 3u * texels, GREY);
}

fn light_behind(acc: Accumulated, plane: u32) -> vec4f {
  return carried(acc.light, acc.around, acc.through, f32(plane) / f32(last_plane()));
}

fn light_at_end(acc: Accumulated) -> vec4f { return light_behind(acc, last_plane()); }

fn finish(acc: Accumulated) -> Result { return Result(acc.through.rgb, 1.0 - acc.through.a, INFINITE); }
