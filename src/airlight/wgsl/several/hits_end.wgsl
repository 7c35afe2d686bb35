// No surface behind the last layer.

import package::kept::Kept;
import package::met::Met;
import package::ray::INFINITE;
import package::several::layer_end::{Faces, Fetches, Lines};

struct Hit { rgb: vec3f, alpha: f32, t_world: f32, met: Met }

fn nearest(front: Fetches, p_front: vec3f, back: Fetches, p_back: vec3f) -> f32 { return 2.0; }

fn hit_at(lines: Lines, front: Fetches, p_front: vec3f, back: Fetches, p_back: vec3f, kept: Kept, faces: Faces) -> Hit {
  return Hit(vec3f(0.0), 0.0, INFINITE, Met(0.0, 0.0, 0u, 0u));
}
