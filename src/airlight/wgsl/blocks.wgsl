// The way of a ray through blocks of voxels. How many may be passed over from one of them: `slot::blocks::leap_of`.

import generated::sizes::BLOCK_VOXELS;
import package::ray::INFINITE;

struct Way {
  origin: vec3f,     // of the ray, in blocks
  direction: vec3f,  // [blocks/world]
  block: vec3f,      // where the ray is from `begin` to `end` [world]
  begin: f32,
  end: f32,
}

// The block at a distance along a ray that is given in index coordinates.
fn way_from(origin_index: vec3f, direction_index: vec3f, t_world: f32) -> Way {
  let origin = origin_index / f32(BLOCK_VOXELS);
  let direction = direction_index / f32(BLOCK_VOXELS);
  let place = origin + t_world * direction;
  // A ray on a face is in the block that it goes into.
  let block = select(floor(place), ceil(place) - 1.0, direction < vec3f(0.0));
  return Way(origin, direction, block, t_world, least(faces_of(origin, direction, block, 1.0)));
}

// Leave all blocks that are nearer than `reach`, which is 1 for the block itself. Through an edge several faces are left at once.
fn step_on(way: Way, reach: f32) -> Way {
  let faces = faces_of(way.origin, way.direction, way.block, reach);
  let begin = max(least(faces), way.begin);
  let inside = clamp(floor(way.origin + begin * way.direction), way.block - (reach - 1.0), way.block + (reach - 1.0));
  let block = select(inside, way.block + sign(way.direction) * reach, faces <= vec3f(begin));
  return Way(way.origin, way.direction, block, begin, max(begin, least(faces_of(way.origin, way.direction, block, 1.0))));
}

// Distances at which the ray leaves the blocks that are nearer than `reach`, along each axis.
fn faces_of(origin: vec3f, direction: vec3f, block: vec3f, reach: f32) -> vec3f {
  let face = block + select(vec3f(1.0 - reach), vec3f(reach), direction > vec3f(0.0));
  return select((face - origin) / direction, vec3f(INFINITE), abs(direction) < vec3f(1e-30));
}

fn least(v: vec3f) -> f32 { return min(v.x, min(v.y, v.z)); }

// For a quick walk from cube to cube: the inverse of a ray's direction in index coordinates, along which axes it goes and which of
// them upwards, and how far behind a face it is taken to be in the next cube, a thousandth of a voxel [world].
struct Pace { rate: vec3f, along: vec3<bool>, up: vec3<bool>, beyond: f32 }

fn pace_of(direction: vec3f) -> Pace {
  let along = abs(direction) > vec3f(1e-30);
  let rate = 1.0 / select(vec3f(1.0), direction, along);
  let pace = max(abs(direction.x), max(abs(direction.y), abs(direction.z)));
  return Pace(rate, along, direction > vec3f(0.0), 1e-3 / pace);
}

// So far a distance goes on at least that 32 bits tell it from the one before, as a share of it.
const TOLD_APART = 2.4e-7;

// Just behind the cube from `low` to `high`, of a ray that is inside at `p` [world].
fn past(pace: Pace, p: vec3f, t_world: f32, low: vec3f, high: vec3f) -> f32 {
  let left = select(vec3f(INFINITE), (select(low, high, pace.up) - p) * pace.rate, pace.along);
  return t_world + max(least(left), 0.0) + max(pace.beyond, TOLD_APART * t_world);
}
