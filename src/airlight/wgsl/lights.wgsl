// What arrives at a point from a light.

import generated::lights::LightRecord;

const HEAD = 0u;
const DIRECTIONAL = 1u;

struct Arriving { rgb: vec3f, to_light: vec3f }

fn arriving(source: LightRecord, p_world: vec3f, to_eye: vec3f) -> Arriving {
  if (source.kind == HEAD) { return Arriving(source.rgb, to_eye); }
  if (source.kind == DIRECTIONAL) { return Arriving(source.rgb, source.vector); }
  let way = source.vector - p_world;
  let distance = max(length(way), 1e-20);
  let near = source.radius / distance;
  return Arriving(source.rgb * select(1.0, near * near, source.radius > 0.0), way / distance);
}

// How far a gradient [data/world] means a surface: not at all up to a threshold, wholly from twice of it on.
fn surfaceness(gradient: vec3f, per_threshold: f32) -> f32 {
  let steepness = clamp(gradient * per_threshold, vec3f(-1e9), vec3f(1e9));
  return saturate(length(steepness) - 1.0);
}
