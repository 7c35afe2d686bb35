// A ray's way through several layers, and the samples on it: `package::walk` for all of them.

import generated::sizes::{CUTS_LAYERS, IN_PARTS, Values};
import next::several::layer::{Lines, are_hidden, are_idle, block_behind, border_of, fetch_all, hold_part, last_border_of, lines_of, parts_at, span_of};
import package::kept::Kept;
import package::ray::Ray;
import package::sample::Sample;
import package::spacing::Spacing;
import slot::clips::kept_from;

// Where index coordinates of all layers would be, the world's.
struct WorldRay { origin: vec3f, direction: vec3f }

// A ray from where it enters the first layer to where it leaves the last one.
struct Line { ray: Ray, index: WorldRay, enter: f32, leave: f32, begin: f32, end: f32, spacing: Spacing, at: u32, lines: Lines }

struct Fetched { value: Values, t_world: f32 }

struct Ends { front: Fetched, back: Fetched }

fn line_of(ray: Ray, pixel: vec2u) -> Line {
  let lines = lines_of(ray, pixel);
  let span = span_of(lines);
  let in_world = WorldRay(ray.origin_world, ray.direction_world);
  return Line(ray, in_world, span.x, span.y, span.x, span.y, lines.own.spacing, lines.own.at, lines);
}

fn fetch(line: Line, t_world: f32) -> Fetched { return Fetched(fetch_all(line.lines, t_world), t_world); }

fn place_of(line: Line, k: f32) -> f32 { return (k + line.spacing.shift) * line.spacing.step_world; }

fn fetch_at(line: Line, k: f32) -> Fetched { return fetch(line, clamp(place_of(line, k), line.enter, line.leave)); }

fn fetch_near(line: Line, k: f32) -> Fetched { return fetch(line, clamp(place_of(line, k), line.begin, line.end)); }

fn sample_of(line: Line, here: Fetched) -> Sample {
  let p_world = line.ray.origin_world + here.t_world * line.ray.direction_world;
  return Sample(here.value, vec3f(0.0), p_world, p_world, here.t_world);
}

fn last_before(line: Line, t_world: f32) -> f32 { return floor(sample_number(line, t_world)); }

fn sample_number(line: Line, t_world: f32) -> f32 { return t_world / line.spacing.step_world - line.spacing.shift; }

// The number of the sample behind the one at which a part of a ray begins, or behind where a ray enters.
fn first_behind(line: Line) -> f32 {
  let number = sample_number(line, line.enter);
  return select(floor(number), round(number), IN_PARTS && line.begin < line.enter) + 1.0;
}

fn is_idle(line: Line, front: Fetched, next: Fetched) -> bool { return are_idle(line.lines, front.value, next.value); }

fn is_hidden(line: Line, front: Fetched, next: Fetched) -> bool { return are_hidden(line.lines, front.value, next.value); }

fn next_block(line: Line, t_world: f32, t_leave: f32) -> f32 { return block_behind(line.lines, t_world, t_leave); }

// Clips of all layers.
fn kept_of(line: Line, t_world: f32, t_leave: f32) -> Kept { return kept_from(line.ray, line.at, t_world, t_leave); }

fn border_behind(line: Line, t_world: f32) -> f32 { return border_of(line.lines, t_world); }

fn border_before(line: Line, t_world: f32) -> f32 { return last_border_of(line.lines, t_world); }

fn hold_layers(part: ptr<function, Line>, whole: Line) -> bool {
  let middle = 0.5 * ((*part).enter + (*part).leave);
  if (CUTS_LAYERS) { (*part).lines = parts_at(whole.lines, middle); }
  return hold_part((*part).lines, middle);
}
