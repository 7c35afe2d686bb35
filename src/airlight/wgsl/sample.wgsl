// What travels between the slots. Lengths and distances are in world units, colours linear and, in slabs, associated.

import generated::sizes::Values;

struct Sample {
  value: Values,      // [data]
  gradient: vec3f,    // [data/world], filled in where a slot asks for it
  p_index: vec3f,
  p_world: vec3f,
  t_world: f32,       // distance from the eye
}

struct Medium { rgb: vec3f, extinction: f32 }  // not associated, or the source itself where the function is associated

// What of a place is drawn: factors of its colour and of its extinction.
struct Part { rgb: vec3f, opacity: f32 }

// The colour of a slab split between its two ends, so that each can be lit by itself.
struct Slab { front_rgb: vec3f, front_specular: f32, back_rgb: vec3f, back_specular: f32, alpha: f32 }

// A surface of equal value that a slab crosses: the share at which a straight line meets it, 2 where there is none; its value, its
// number in the stage's own order, and whether values rise through it; colour and opacity of the side that is seen.
struct Sheet { share: f32, level: f32, number: u32, rises: bool, rgb: vec3f, alpha: f32 }

struct Lit { diffuse: vec3f, specular: vec3f }

struct Result { rgb: vec3f, alpha: f32, t_world: f32 }
