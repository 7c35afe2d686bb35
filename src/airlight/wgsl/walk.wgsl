// A ray's way through the domain, and the samples on it: what the kinds of walks share. How a walk finds the next slab that
// matters: `slot::walk`.

import generated::frame::frame;
import generated::layer::layer;
import generated::sizes::{CUTS_LAYERS, IN_PARTS, SKIPS_EMPTY, SURFACES_ONLY, Values};
import package::blocks::{Run, Way, enters, just_behind, leaves, way_of};
import package::kept::Kept;
import package::ray::{Ray, INFINITE};
import package::sample::Sample;
import package::spacing::Spacing;
import slot::blocks::leap_of;
import slot::clips::kept_by;
import slot::field::{locate, field_value};
import slot::integrate::surface;
import slot::lattice::spacing_of;
import slot::region::hidden_at;
import slot::transfer::empty_slab;

// The same ray in index coordinates, still measured in world units.
struct IndexRay { origin: vec3f, direction: vec3f }

// A ray from where it enters the domain to where it leaves it, where its samples lie, and its pixel's number. Of a part of a ray that
// goes on from another, `begin` is where the first one enters, and of one that others go on from, `end` where the last one leaves.
struct Line { ray: Ray, index: IndexRay, enter: f32, leave: f32, begin: f32, end: f32, spacing: Spacing, at: u32 }

fn ray_in_index(ray: Ray) -> IndexRay {
  return IndexRay(
    (layer.index_from_world * vec4f(ray.origin_world, 1.0)).xyz,
    (layer.index_from_world * vec4f(ray.direction_world, 0.0)).xyz,
  );
}

fn line_of(ray: Ray, pixel: vec2u) -> Line {
  let index = ray_in_index(ray);
  let span = domain_span(index);
  let at = (pixel.y - frame.band_first_row) * frame.size_px.x + pixel.x;
  return Line(ray, index, span.x, span.y, span.x, span.y, spacing_of(ray, pixel), at);
}

// What a sample is made of: few numbers are carried through loops.
struct Fetched { value: Values, t_world: f32 }

struct Ends { front: Fetched, back: Fetched }

fn fetch(line: Line, t_world: f32) -> Fetched {
  return Fetched(field_value(locate(line.index.origin + t_world * line.index.direction)), t_world);
}

// Samples lie on a lattice, but for the first and the last.
fn place_of(line: Line, k: f32) -> f32 { return (k + line.spacing.shift) * line.spacing.step_world; }

fn fetch_at(line: Line, k: f32) -> Fetched { return fetch(line, clamp(place_of(line, k), line.enter, line.leave)); }

// A sample that may lie before the part of a ray, or behind it.
fn fetch_near(line: Line, k: f32) -> Fetched { return fetch(line, clamp(place_of(line, k), line.begin, line.end)); }

fn sample_of(line: Line, here: Fetched) -> Sample {
  let p_world = line.ray.origin_world + here.t_world * line.ray.direction_world;
  let p_index = line.index.origin + here.t_world * line.index.direction;
  return Sample(here.value, vec3f(0.0), p_index, p_world, here.t_world);
}

// The number of the last sample of the lattice that is not behind a place.
fn last_before(line: Line, t_world: f32) -> f32 { return floor(sample_number(line, t_world)); }

fn sample_number(line: Line, t_world: f32) -> f32 { return t_world / line.spacing.step_world - line.spacing.shift; }

// The number of the sample behind the one at which a part of a ray begins, or behind where a ray enters.
fn first_behind(line: Line) -> f32 {
  let number = sample_number(line, line.enter);
  return select(floor(number), round(number), IN_PARTS && line.begin < line.enter) + 1.0;
}

// Whether a slab leaves the result as it is, told from its two samples alone.
fn is_idle(line: Line, front: Fetched, next: Fetched) -> bool {
  if (SURFACES_ONLY) { return surface(sample_of(line, front), sample_of(line, next)) > 1.0; }
  return SKIPS_EMPTY && empty_slab(sample_of(line, front), sample_of(line, next));
}

// Whether a slab is in a region of which nothing is drawn.
fn is_hidden(line: Line, front: Fetched, next: Fetched) -> bool {
  return SKIPS_EMPTY && hidden_at(line.index.origin + mix(front.t_world, next.t_world, 0.5) * line.index.direction);
}

// Where, from a distance on, a ray meets the first block in which there may be something to be seen.
fn next_block(line: Line, t_world: f32, t_leave: f32) -> f32 {
  let way = way_of(line.index.origin, line.index.direction);
  return leapt(way, t_world, t_leave).t_world - way.beyond;
}

// The way through that block; from the distance on where it lies in the block.
fn run_behind(line: Line, way: Way, t_world: f32) -> Run {
  let found = leapt(way, t_world, line.leave);
  let begin = select(t_world, max(enters(way, found.block), t_world), found.leaps);
  return Run(min(begin, line.leave), min(max(leaves(way, found.block, 1.0), found.t_world), line.leave));
}

// A block, a distance just behind where the ray enters it, and whether others were passed over.
struct Leapt { block: vec3f, t_world: f32, leaps: bool }

fn leapt(way: Way, t_world: f32, t_leave: f32) -> Leapt {
  var found = Leapt(vec3f(0.0), just_behind(way, t_world), false);
  loop {
    found.block = floor(way.origin + found.t_world * way.direction);
    let reach = leap_of(found.block);
    if (reach == 0.0 || found.t_world >= t_leave) { break; }
    found.t_world = just_behind(way, max(leaves(way, found.block, reach), found.t_world));
    found.leaps = true;
  }
  return found;
}

// The next piece that clips keep, of one of several layers all that cut it.
fn kept_of(line: Line, t_world: f32, t_leave: f32) -> Kept {
  return kept_by(select(0u, layer.first_clip, CUTS_LAYERS), line.ray, line.at, t_world, t_leave);
}

// The next distance at which a layer begins or ends, where slabs are cut; a single one does with its ray.
fn border_behind(line: Line, t_world: f32) -> f32 { return line.leave; }

// The last such distance that is not behind another.
fn border_before(line: Line, t_world: f32) -> f32 { return line.enter; }

// Whether a part of a ray that holds no such distance lies in a layer; of several layers it is told which of them it lies in.
fn hold_layers(part: ptr<function, Line>, whole: Line) -> bool { return true; }

// Where the ray enters and leaves the domain, not before the eye [world].
fn domain_span(ray: IndexRay) -> vec2f {
  // A ray along a face has no direction across it: it is outside, or it is held by the other faces. One without a direction
  // meets nothing.
  let across = abs(ray.direction) <= vec3f(1e-7 * max(abs(ray.direction.x), max(abs(ray.direction.y), abs(ray.direction.z))));
  let outside = across & ((ray.origin < layer.domain_low) | (ray.origin > layer.domain_high));
  if (any(outside) || all(across)) { return vec2f(0.0); }
  let rate = select(ray.direction, vec3f(1.0), across);
  let a = select((layer.domain_low - ray.origin) / rate, vec3f(-INFINITE), across);
  let b = select((layer.domain_high - ray.origin) / rate, vec3f(INFINITE), across);
  let near = min(a, b);
  let far = max(a, b);
  return vec2f(max(max(near.x, near.y), max(near.z, 0.0)), min(far.x, min(far.y, far.z)));
}
