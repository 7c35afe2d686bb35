// What fills the slots of layers for what lies outside of several of them: each layer asks its own stages by itself.

import generated::sizes::Values;
import next::several::layer::{Knowns, know_all, know_all_empty};
import package::sample::{Medium, Part, Sample};

struct Place { nothing: f32 }

fn locate(p_world: vec3f) -> Place { return Place(0.0); }

fn field_gradient(place: Place) -> vec3f { return vec3f(0.0); }

fn is_gap(value: Values) -> bool { return false; }

// Layers thin and tint their slabs themselves.
fn weight(front: Sample, back: Sample, length: f32) -> f32 { return 1.0; }

fn part_at(p_index: vec3f) -> Part { return Part(vec3f(1.0), 1.0); }

// What is known of a sample in each layer.
fn know(here: Sample) -> Knowns { return know_all(here.value, here.p_world); }

fn know_empty(here: Sample) -> Knowns { return know_all_empty(here.value, here.p_world); }

// Of all layers at once no medium is known, nor a block that holds but one.
fn medium(here: Sample) -> Medium { return Medium(vec3f(0.0), 0.0); }

fn even_of(block: vec3f) -> f32 { return 0.0; }
