// Ways through cells, in which places are counted.

const LEAST_SHARE: f32 = 1e-6;
const FAR: f32 = 1e30;

// Between which multiples of a way there is something. A way along a face that begins on it is inside.
fn stretch(p_cell: vec3f, way: vec3f, low: vec3f, high: vec3f) -> vec2f {
  let along = abs(way) <= vec3f(LEAST_SHARE * max(abs(way.x), max(abs(way.y), abs(way.z))));
  let pace = select(way, vec3f(1.0), along);
  let one = (low - p_cell) / pace;
  let other = (high - p_cell) / pace;
  let misses = along & ((p_cell < low) | (p_cell > high));
  let begin = select(min(one, other), select(vec3f(0.0), vec3f(FAR), misses), along);
  let end = select(max(one, other), vec3f(FAR), along);
  return vec2f(max(max(begin.x, begin.y), max(begin.z, 0.0)), min(min(end.x, end.y), end.z));
}

// Integral of what cells hold over a part of a way, in even steps of at most a cell along each axis, each taken in its middle.
fn held_between(
  cells: texture_3d<f32>, cells_sampler: sampler, unit_per_cell: vec3f, p_cell: vec3f, way: vec3f, begin: f32, end: f32,
) -> vec3f {
  let sides = abs(way) * max(end - begin, 0.0);
  let steps = max(ceil(max(sides.x, max(sides.y, sides.z)) - 1e-3), 1.0);
  var held = vec3f(0.0);
  for (var k = 0.0; k < steps; k += 1.0) {
    let place = p_cell + (begin + (k + 0.5) / steps * (end - begin)) * way;
    held += textureSampleLevel(cells, cells_sampler, place * unit_per_cell, 0.0).rgb;
  }
  return held * (max(end - begin, 0.0) / steps);
}
