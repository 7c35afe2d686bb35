// The way of a ray through blocks of voxels. How many may be passed over from one of them: `slot::blocks::leap_of`.

import generated::sizes::BLOCK_VOXELS;
import package::ray::INFINITE;

const ENDLESS = 1e37;  // a leap of so many times is a number yet

// A ray in blocks: its origin and direction [blocks/world], the latter's inverse, 0 along axes along which it does not go, how far it
// is through a block along each axis, which of a block's faces it enters by, 0 or 1, and how far behind a face it is taken to be in the
// next block, a thousandth of a voxel [world].
struct Way { origin: vec3f, direction: vec3f, rate: vec3f, through: vec3f, near: vec3f, beyond: f32 }

// A part of a way [world].
struct Run { begin: f32, end: f32 }

fn way_of(origin_index: vec3f, direction_index: vec3f) -> Way {
  let pace = pace_of(direction_index);
  let side = f32(BLOCK_VOXELS);
  let rate = select(vec3f(0.0), pace.rate * side, pace.along);
  let through = select(vec3f(ENDLESS), abs(rate), pace.along);
  return Way(origin_index / side, direction_index / side, rate, through, select(vec3f(1.0), vec3f(0.0), pace.up), pace.beyond);
}

// Just behind a distance [world].
fn just_behind(way: Way, t_world: f32) -> f32 { return t_world + max(way.beyond, TOLD_APART * t_world); }

// Where the ray passes the planes of the faces by which it enters a block [world]; 0 along axes along which it does not go.
fn near_faces(way: Way, block: vec3f) -> vec3f { return (block + way.near - way.origin) * way.rate; }

// Where the ray leaves the blocks that are nearer to one than `reach`, which is 1 for the block itself [world].
fn leaves(way: Way, block: vec3f, reach: f32) -> f32 { return least(near_faces(way, block) + reach * way.through); }

// Where the ray enters a block, if it begins before that [world].
fn enters(way: Way, block: vec3f) -> f32 {
  let t_world = near_faces(way, block);
  return max(t_world.x, max(t_world.y, t_world.z));
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
