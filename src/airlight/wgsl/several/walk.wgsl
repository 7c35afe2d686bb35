// A ray's way through several layers, and the samples on it: `package::walk` for all of them.

import generated::frame::frame;
import generated::sizes::Values;
import next::several::layer::{Lines, are_hidden, are_idle, block_behind, border_of, fetch_all, hold_part, lines_of, span_of};
import package::ray::Ray;
import package::sample::Sample;

// Where index coordinates of all layers would be, the world's.
struct WorldRay { origin: vec3f, direction: vec3f }

// A ray from where it enters the first layer to where it leaves the last one.
struct Line { ray: Ray, index: WorldRay, enter: f32, leave: f32, offset: f32, at: u32, lines: Lines }

struct Fetched { value: Values, t_world: f32 }

struct Ends { front: Fetched, back: Fetched }

fn line_of(ray: Ray, pixel: vec2u) -> Line {
  let lines = lines_of(ray, pixel);
  let span = span_of(lines);
  return Line(ray, WorldRay(ray.origin_world, ray.direction_world), span.x, span.y, lines.own.offset, lines.own.at, lines);
}

fn fetch(line: Line, t_world: f32) -> Fetched { return Fetched(fetch_all(line.lines, t_world), t_world); }

fn fetch_at(line: Line, k: f32) -> Fetched {
  return fetch(line, clamp((k + line.offset) * frame.step_world, line.enter, line.leave));
}

fn sample_of(line: Line, here: Fetched) -> Sample {
  let p_world = line.ray.origin_world + here.t_world * line.ray.direction_world;
  return Sample(here.value, vec3f(0.0), p_world, p_world, here.t_world);
}

fn last_before(line: Line, t_world: f32) -> f32 { return floor(t_world / frame.step_world - line.offset); }

fn is_idle(line: Line, front: Fetched, next: Fetched) -> bool { return are_idle(line.lines, front.value, next.value); }

fn is_hidden(line: Line, front: Fetched, next: Fetched) -> bool { return are_hidden(line.lines, front.value, next.value); }

fn next_block(line: Line, t_world: f32, t_leave: f32) -> f32 { return block_behind(line.lines, t_world, t_leave); }

fn border_behind(line: Line, t_world: f32) -> f32 { return border_of(line.lines, t_world); }

fn holds_layer(line: Line) -> bool { return hold_part(line.lines, 0.5 * (line.enter + line.leave)); }
