// Nothing is cut away.

import package::kept::Kept;
import package::ray::Ray;

const HAS_CLIPS = false;

fn kept_from(ray: Ray, pixel: u32, t_world: f32, t_leave: f32) -> Kept { return Kept(t_world, t_leave, 0u, 0u); }

fn kept_by(first: u32, ray: Ray, pixel: u32, t_world: f32, t_leave: f32) -> Kept { return Kept(t_world, t_leave, 0u, 0u); }

fn cut_normal(number: u32, p_world: vec3f) -> vec3f { return vec3f(0.0); }

fn is_kept(p: vec3f) -> bool { return true; }

fn is_capped(number: u32) -> bool { return false; }
