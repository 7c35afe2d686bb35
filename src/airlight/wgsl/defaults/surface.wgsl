// No surface: the ray goes on.

import package::sample::Sample;

fn surface(front: Sample, back: Sample) -> f32 { return 2.0; }

fn level(front: Sample, back: Sample) -> f32 { return 0.0; }

fn surface_rgb(hit: Sample, front: Sample, back: Sample, rgb: vec3f) -> vec3f { return rgb; }
