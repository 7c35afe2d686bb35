// No closed mesh clips.

import package::kept::Kept;

fn outlined_from(list: u32, pixel: u32, t_world: f32) -> Kept { return Kept(t_world, t_world, 0u, 0u); }

fn is_outline(number: u32) -> bool { return false; }

fn outline_normal(number: u32) -> vec3f { return vec3f(0.0); }

fn is_outline_capped(number: u32) -> bool { return false; }
