// Where between two samples a ray meets a surface of equal value, sharper than by a straight line: halving (Scharsach, section
// 4: six steps leave a 64th), halving to a share of a voxel and then straight lines, or the root of the cubic that a trilinear
// field is along a ray in the cell where the surface is.

import generated::driver::REFINE;
import generated::sizes::HAS_EMPTY;
import package::empty::is_empty;
import package::ray::INFINITE;
import slot::field::{locate, field_value};
import slot::values::scalar_of;

const BISECTION = 1u;
const SECANT = 2u;
const EXACT = 3u;
const HALVINGS = 6u;
const LINES = 2u;
const NARROW_VOXELS = 0.05;
const MOST_HALVINGS = 20u;

// A ray in index coordinates, and the value for which it is searched.
struct Search { origin_index: vec3f, direction_index: vec3f, level: f32, nothing: f32 }

// The distance at which the value passes the level. `near` and `far` are distances [world] and values on either side of it.
fn refined(origin_index: vec3f, direction_index: vec3f, near: vec2f, far: vec2f, level: f32) -> f32 {
  let search = Search(origin_index, direction_index, level, near.y);
  var bracket = vec4f(near, far);
  // Lines meet bends of the field, which are voxels apart, better in a narrow bracket, however long the step; cells are few there.
  var narrow = 0.0;
  if (REFINE == SECANT) { narrow = NARROW_VOXELS / length(direction_index); }
  if (REFINE == EXACT) { narrow = 1.0 / length(direction_index); }
  for (var i = 0u; i < select(MOST_HALVINGS, HALVINGS, REFINE == BISECTION); i++) {
    if (bracket.z - bracket.x <= narrow) { break; }
    bracket = narrowed(search, bracket, 0.5 * (bracket.x + bracket.z));
  }
  if (REFINE == SECANT) {
    for (var i = 0u; i < LINES; i++) { bracket = narrowed(search, bracket, straight(bracket, level)); }
  }
  if (REFINE == EXACT) { return root_between(search, bracket); }
  return straight(bracket, level);
}

// What is empty counts as what lies before the surface.
fn scalar_along(search: Search, t_world: f32) -> f32 {
  let value = scalar_of(field_value(locate(search.origin_index + t_world * search.direction_index)));
  if (HAS_EMPTY) { return select(value, search.nothing, is_empty(value)); }
  return value;
}

fn narrowed(search: Search, bracket: vec4f, t_world: f32) -> vec4f {
  let value = scalar_along(search, t_world);
  let is_far = (value >= search.level) == (bracket.w >= search.level);
  return select(vec4f(t_world, value, bracket.zw), vec4f(bracket.xy, t_world, value), is_far);
}

fn straight(bracket: vec4f, level: f32) -> f32 {
  let rise = bracket.w - bracket.y;
  return mix(bracket.x, bracket.z, saturate((level - bracket.y) / select(rise, 1.0, rise == 0.0)));
}

// The root in the first cell of a bracket at whose end the value is beyond the level; where rounding hides it, that end.
fn root_between(search: Search, bracket: vec4f) -> f32 {
  let origin = search.origin_index;
  let direction = search.direction_index;
  let p = origin + bracket.x * direction;
  let along = abs(direction) < vec3f(1e-30);
  var face = select(ceil(p) - 1.0, floor(p) + 1.0, direction > vec3f(0.0));
  var cell = bracket;
  loop {
    let t_faces = select((face - origin) / direction, vec3f(INFINITE), along);
    cell.z = clamp(min(t_faces.x, min(t_faces.y, t_faces.z)), cell.x, bracket.z);
    cell.w = scalar_along(search, cell.z);
    if (cell.z >= bracket.z || (cell.w >= search.level) == (bracket.w >= search.level)) { break; }
    face += select(vec3f(0.0), sign(direction), t_faces <= vec3f(cell.z));
    cell = vec4f(cell.zw, cell.zw);
  }
  let side = front_side(search);
  let beyond = beyond_along(search, side, cell.x, side * (cell.y - search.level), cell.z, side * (cell.w - search.level));
  var rise = rise_of(beyond, cell.x, cell.z);
  rise.piece = select(vec2f(1.0), rise.piece, rise.piece.y >= 0.0);
  return root_of(rise);
}

fn root_of(rise: Rise) -> f32 {
  var piece = rise.piece;
  for (var i = 0u; i <= HALVINGS; i++) {
    let middle = 0.5 * (piece.x + piece.y);
    piece = select(vec2f(middle, piece.y), vec2f(piece.x, middle), cubic(rise.c, middle) >= 0.0);
  }
  let share = straight(vec4f(piece.x, cubic(rise.c, piece.x), piece.y, cubic(rise.c, piece.y)), 0.0);
  return mix(rise.begin, rise.end, share);
}

// How far beyond the level the field is, seen from the front, at both ends of a way within one cell and at its thirds.
fn beyond_between(origin_index: vec3f, direction_index: vec3f, near: vec2f, far: vec2f, level: f32) -> vec4f {
  let search = Search(origin_index, direction_index, level, near.y);
  let side = front_side(search);
  return beyond_along(search, side, near.x, side * (near.y - level), far.x, side * (far.y - level));
}

// False only where the cubic stays before the level: as long as all its coefficients by Bernstein do.
fn may_rise(beyond: vec4f) -> bool {
  let inner = vec2f(dot(beyond, vec4f(-5.0, 18.0, -9.0, 2.0)), dot(beyond, vec4f(2.0, -9.0, 18.0, -5.0)));
  return any(inner >= vec2f(0.0)) || beyond.x >= 0.0 || beyond.w >= 0.0;
}

fn rise_of(beyond: vec4f, begin: f32, end: f32) -> Rise {
  let c = cubic_through(beyond);
  return Rise(c, rising_piece(c), begin, end);
}

fn front_side(search: Search) -> f32 { return select(1.0, -1.0, search.nothing >= search.level); }

// Where the field passes to the other side of the level: distances [world] at which the ray enters and leaves the cell, the cubic
// there (negative on the side of the front), and its piece as of `rising_piece`.
struct Rise { c: vec4f, piece: vec2f, begin: f32, end: f32 }

fn beyond_along(search: Search, side: f32, begin: f32, y: f32, end: f32, z: f32) -> vec4f {
  let a = side * (scalar_along(search, mix(begin, end, 1.0 / 3.0)) - search.level);
  let b = side * (scalar_along(search, mix(begin, end, 2.0 / 3.0)) - search.level);
  return vec4f(y, a, b, z);
}

// The cubic that has four values at equal distances from 0 to 1.
fn cubic_through(v: vec4f) -> vec4f {
  return vec4f(
    v.x,
    -5.5 * v.x + 9.0 * v.y - 4.5 * v.z + v.w,
    9.0 * v.x - 22.5 * v.y + 18.0 * v.z - 4.5 * v.w,
    4.5 * (v.w - v.x) + 13.5 * (v.y - v.z),
  );
}

fn cubic(c: vec4f, u: f32) -> f32 { return c.x + u * (c.y + u * (c.z + u * c.w)); }

// The first piece of [0, 1] between extremes of a cubic at whose end it is not negative; its end is negative where there is none.
fn rising_piece(c: vec4f) -> vec2f {
  // Roots of the derivative, without loss where the cubic is nearly straight.
  let half = -c.z - select(-1.0, 1.0, c.z >= 0.0) * sqrt(max(c.z * c.z - 3.0 * c.w * c.y, 0.0));
  let one = half / select(3.0 * c.w, 1e-30, c.w == 0.0);
  let other = c.y / select(half, 1e-30, half == 0.0);
  let bends = c.z * c.z > 3.0 * c.w * c.y;
  let low = select(1.0, saturate(min(one, other)), bends);
  let high = select(1.0, saturate(max(one, other)), bends);
  if (cubic(c, low) >= 0.0) { return vec2f(0.0, low); }
  if (cubic(c, high) >= 0.0) { return vec2f(low, high); }
  return select(vec2f(0.0, -1.0), vec2f(high, 1.0), cubic(c, 1.0) >= 0.0);
}
