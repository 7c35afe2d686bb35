// Rays cut by clips. A clip answers with the piece of a ray that it keeps next; what all of them keep is drawn. Shapes are met in one
// piece by any line, closed meshes in many: `slot::outlines`. They tell themselves how many there are: Mesa 22.3 (lavapipe) makes a loop that ends by a uniform a constant one,
// compiles that anew for each dispatch, and keeps them all.

import generated::clips::ClipRecord;
import generated::pass::clips;
import package::kept::Kept;
import package::ray::{Ray, INFINITE};
import slot::outlines::{outlined_from, is_outline, outline_normal, is_outline_capped};

const HAS_CLIPS = true;
const PLANE = 0u;
const BOX = 1u;
const MESH = 3u;
const CUTS_VOLUME = 0u;  // what clips cut away: see `airlight.clips.Clip.cuts`
const CUTS_FRONT = 1u;

// The piece at a distance [world] or behind it that all clips keep; it does not begin before `t_leave` where there is none.
fn kept_from(ray: Ray, pixel: u32, t_world: f32, t_leave: f32) -> Kept { return kept_by(0u, ray, pixel, t_world, t_leave); }

// The same of a group of clips, by the place of its first.
fn kept_by(first: u32, ray: Ray, pixel: u32, t_world: f32, t_leave: f32) -> Kept {
  var kept = Kept(t_world, t_leave, 0u, 0u);
  let end = clips[first].end;
  // Go on to where a clip's piece begins, until all agree: a piece may begin where another clip keeps nothing.
  loop {
    let begin = kept.begin;
    kept.end = t_leave;
    kept.far = 0u;
    for (var i = first; i < end; i++) {
      var piece: Kept;
      if (clips[i].kind == MESH) { piece = outlined_from(clips[i].list, pixel, kept.begin); } else {
        let span = piece_from(clips[i], ray, kept.begin);
        piece = Kept(span.x, span.y, i + 1u, i + 1u);
      }
      kept.near = select(kept.near, piece.near, piece.begin > kept.begin);
      kept.far = select(kept.far, piece.far, piece.end < kept.end);
      kept.begin = max(kept.begin, piece.begin);
      kept.end = min(kept.end, piece.end);
    }
    if (!(kept.begin > begin && kept.begin < t_leave)) { break; }
  }
  return kept;
}

// Normal of a clip's surface, towards what is cut away.
fn cut_normal(number: u32, p_world: vec3f) -> vec3f {
  if (is_outline(number)) { return outline_normal(number); }
  let clip = clips[number - 1u];
  let unit = unit_of(clip, p_world);
  var away = unit;
  // A mesh is asked where no clip cuts: it answers with something finite.
  if (clip.kind == PLANE || clip.kind == MESH) { away = vec3f(-1.0, 0.0, 0.0); }
  if (clip.kind == BOX) {
    let size = abs(unit);
    away = select(vec3f(0.0), sign(unit), size >= vec3f(max(size.x, max(size.y, size.z))));
  }
  let normal = normalize(away.x * clip.x.xyz + away.y * clip.y.xyz + away.z * clip.z.xyz);
  return select(-normal, normal, clip.keeps_inside != 0u);
}

// Whether a point is drawn, in the coordinates that clips are told in.
fn is_kept(p: vec3f) -> bool {
  var is_kept_by_all = true;
  for (var i = 0u; i < clips[0].end; i++) {
    let clip = clips[i];
    let unit = unit_of(clip, p);
    let size = abs(unit);
    var is_inside = dot(unit, unit) <= 1.0;
    if (clip.kind == PLANE) { is_inside = unit.x >= 0.0; }
    if (clip.kind == BOX) { is_inside = all(size <= vec3f(1.0)); }
    is_kept_by_all &= is_inside == (clip.keeps_inside != 0u);
  }
  return is_kept_by_all;
}

fn unit_of(clip: ClipRecord, p: vec3f) -> vec3f {
  let point = vec4f(p, 1.0);
  return vec3f(dot(clip.x, point), dot(clip.y, point), dot(clip.z, point));
}

fn is_capped(number: u32) -> bool {
  if (is_outline(number)) { return is_outline_capped(number); }
  return number > 0u && clips[max(number, 1u) - 1u].capped != 0u;
}

// The next piece that one clip keeps: it begins at `t_world` or behind it.
fn piece_from(clip: ClipRecord, ray: Ray, t_world: f32) -> vec2f {
  let inside = reaching(clip, inside_of(clip, ray));
  let is_before = t_world < inside.x;
  let is_behind = t_world >= inside.y;
  if (clip.keeps_inside != 0u) {
    return select(vec2f(max(t_world, inside.x), inside.y), vec2f(INFINITE), is_behind || inside.x >= inside.y);
  }
  let begin = select(inside.y, t_world, is_before || is_behind || inside.x >= inside.y);
  return vec2f(begin, select(INFINITE, inside.x, is_before && inside.x < inside.y));
}

// What counts as inside of a clip that cuts in front or behind alone: all from where its shape begins, or up to where it ends.
fn reaching(clip: ClipRecord, inside: vec2f) -> vec2f {
  let keeps_inside = clip.keeps_inside != 0u;
  let is_met = inside.x < inside.y && inside.y > 0.0;
  let reach = select(vec2f(-INFINITE, inside.y), vec2f(inside.x, INFINITE), (clip.cuts == CUTS_FRONT) == keeps_inside);
  let missed = select(vec2f(INFINITE, -INFINITE), vec2f(-INFINITE, INFINITE), keeps_inside);
  return select(select(missed, reach, is_met), inside, clip.cuts == CUTS_VOLUME);
}

// Where the line of a ray enters and leaves a shape; it leaves first where it misses it.
fn inside_of(clip: ClipRecord, ray: Ray) -> vec2f {
  let origin = unit_of(clip, ray.origin_world);
  let d = ray.direction_world;
  let direction = vec3f(dot(clip.x.xyz, d), dot(clip.y.xyz, d), dot(clip.z.xyz, d));
  if (clip.kind == PLANE) { return above(origin.x, direction.x); }
  if (clip.kind == BOX) {
    let low_x = above(origin.x + 1.0, direction.x);
    let low_y = above(origin.y + 1.0, direction.y);
    let low_z = above(origin.z + 1.0, direction.z);
    let high_x = above(1.0 - origin.x, -direction.x);
    let high_y = above(1.0 - origin.y, -direction.y);
    let high_z = above(1.0 - origin.z, -direction.z);
    let begin = max(max(low_x.x, low_y.x), max(low_z.x, max(high_x.x, max(high_y.x, high_z.x))));
    return vec2f(begin, min(min(low_x.y, low_y.y), min(low_z.y, min(high_x.y, min(high_y.y, high_z.y)))));
  }
  // From the point of the line that is nearest to the middle.
  let pace = dot(direction, direction);
  let t_near = -dot(origin, direction) / pace;
  let nearest = origin + t_near * direction;
  let rest = 1.0 - dot(nearest, nearest);
  let reach = sqrt(max(rest, 0.0) / pace);
  return select(vec2f(t_near - reach, t_near + reach), vec2f(INFINITE, -INFINITE), rest <= 0.0);
}

// Where `origin + t * rate` is not negative.
fn above(origin: f32, rate: f32) -> vec2f {
  let t = -origin / select(rate, 1.0, rate == 0.0);
  let along = select(vec2f(INFINITE, -INFINITE), vec2f(-INFINITE, INFINITE), origin >= 0.0);
  return select(select(vec2f(-INFINITE, t), vec2f(t, INFINITE), rate > 0.0), along, rate == 0.0);
}
