// Behind the last layer.

import package::ray::{Ray, INFINITE};
import package::several::mixing::{Caps, Mixed};

struct Lines { nothing: f32 }
struct Fetches { nothing: f32 }
struct Knowns { nothing: f32 }
struct Lights { nothing: f32 }
struct Faces { nothing: f32 }
struct Sent { mixed: Mixed, knowns: Knowns, lights: Lights }

fn lines_of(ray: Ray, pixel: vec2u) -> Lines { return Lines(0.0); }

fn span_of(lines: Lines) -> vec2f { return vec2f(INFINITE, 0.0); }

fn border_of(lines: Lines, t_world: f32) -> f32 { return INFINITE; }

fn last_border_of(lines: Lines, t_world: f32) -> f32 { return 0.0; }

fn hold_part(lines: Lines, t_world: f32) -> bool { return false; }

fn parts_at(lines: Lines, t_world: f32) -> Lines { return lines; }

fn block_behind(lines: Lines, t_world: f32, t_leave: f32) -> f32 { return INFINITE; }

fn fetch_all(lines: Lines, t_world: f32) -> Fetches { return Fetches(0.0); }

fn curve(before: Fetches, here: Fetches, after: Fetches) -> Fetches { return here; }

fn are_idle(lines: Lines, front: Fetches, next: Fetches) -> bool { return true; }

fn are_hidden(lines: Lines, front: Fetches, next: Fetches) -> bool { return true; }

fn know_all(values: Fetches, p_world: vec3f) -> Knowns { return Knowns(0.0); }

fn know_all_empty(values: Fetches, p_world: vec3f) -> Knowns { return Knowns(0.0); }

fn send(
  knowns: Knowns, lights: Lights, is_lit: bool, near: Fetches, p_near: vec3f, far: Fetches, p_far: vec3f, share: f32, faces: Faces,
  ray: Ray,
) -> Sent {
  return Sent(Mixed(vec3f(0.0), 0.0), knowns, lights);
}

fn cuts_of(number: u32, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Faces { return Faces(0.0); }

fn caps_of(number: u32, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Caps { return Caps(vec3f(0.0), 0.0); }

fn own_cuts_of(faces: Faces, lines: Lines, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Faces { return faces; }

fn own_caps_of(lines: Lines, cut: Fetches, p_world: vec3f, t_world: f32, ray: Ray) -> Caps { return Caps(vec3f(0.0), 0.0); }
