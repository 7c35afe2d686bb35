// Light between cells, which have one more all round them: places are counted in cells, from the corner of the volume.

import generated::occlusion::params as occlusion;
import generated::pass::{occluders, occluders_sampler};
import generated::shadow::params as shadow;

const LEAST_SHARE: f32 = 1e-6;
const FAR: f32 = 1e30;

fn middle_of(texel: vec3u) -> vec3f { return vec3f(texel) - 0.5; }

fn to_light(p_cell: vec3f) -> vec3f { return shadow.light.xyz - shadow.light.w * p_cell; }

// Between which multiples of a way there is something. A way along a face that begins on it is inside.
fn stretch(p_cell: vec3f, way: vec3f) -> vec2f {
  let along = abs(way) <= vec3f(LEAST_SHARE * max(abs(way.x), max(abs(way.y), abs(way.z))));
  let pace = select(way, vec3f(1.0), along);
  let one = (shadow.low - p_cell) / pace;
  let other = (shadow.high - p_cell) / pace;
  let misses = along & ((p_cell < shadow.low) | (p_cell > shadow.high));
  let begin = select(min(one, other), select(vec3f(0.0), vec3f(FAR), misses), along);
  let end = select(max(one, other), vec3f(FAR), along);
  return vec2f(max(max(begin.x, begin.y), max(begin.z, 0.0)), min(min(end.x, end.y), end.z));
}

// What comes through along a part of a way, in even steps of at most a cell along each axis, each taken in its middle.
fn through(p_cell: vec3f, way: vec3f, begin: f32, end: f32) -> vec3f {
  let sides = abs(way) * max(end - begin, 0.0);
  let steps = max(ceil(max(sides.x, max(sides.y, sides.z)) - 1e-3), 1.0);
  var depth = vec3f(0.0);
  for (var k = 0.0; k < steps; k += 1.0) {
    let place = p_cell + (begin + (k + 0.5) / steps * (end - begin)) * way;
    depth += textureSampleLevel(occluders, occluders_sampler, place / vec3f(occlusion.cells), 0.0).rgb;
  }
  let step_world = length(shadow.world_from_cells * way) * max(end - begin, 0.0) / steps;
  return exp(-depth * (step_world / occlusion.cell_world));
}
