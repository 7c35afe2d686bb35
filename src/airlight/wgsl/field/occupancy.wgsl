// Which share of a place regions take that are drawn.

import generated::sizes::Values;
import package::ray::INFINITE;
import slot::region::mixed_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values { return mixed_at(place.p_index).taken; }

fn field_scalar(place: Place) -> f32 { return mixed_at(place.p_index).tinted.a; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
