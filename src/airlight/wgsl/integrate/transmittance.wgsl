// What comes through along a ray of a light, kept at each plane that it passes.

import generated::lamp::params as lamp;
import generated::pass::light_planes_out;
import package::ray::INFINITE;
import package::sample::{Sample, Slab, Result};
import slot::transport::{Gathered, carried, passing};

// Light at the first plane and what is gathered round it; the place of that plane on the ray, and the next one that is not kept yet.
struct Accumulated {
  through: vec4f,
  light: vec4f,
  around: Gathered,
  texel: vec2u,
  is_new: bool,
  next: u32,
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
  let count = textureDimensions(light_planes_out).z;
  let passed = u32(clamp(floor((t_world - (*acc).first_world) / (*acc).step_world + TOUCHES) + 1.0, 0.0, f32(count)));
  let is_old = !(*acc).is_new;
  // Where nothing has changed to the last plane, planes are as they were first written.
  if (is_old && all(light_behind(*acc, count - 1u) == lamp.begins)) { (*acc).next = max((*acc).next, passed); }
  loop {
    let next = (*acc).next;
    if (next >= passed) { break; }
    let light = light_behind(*acc, next);
    if (!is_old || any(light != lamp.begins)) { textureStore(light_planes_out, vec3u((*acc).texel, next), light); }
    (*acc).next = next + 1u;
  }
}

fn light_behind(acc: Accumulated, plane: u32) -> vec4f {
  return carried(acc.light, acc.around, acc.through, f32(plane) / f32(textureDimensions(light_planes_out).z - 1u));
}

fn finish(acc: Accumulated) -> Result { return Result(acc.through.rgb, 1.0 - acc.through.a, INFINITE); }
