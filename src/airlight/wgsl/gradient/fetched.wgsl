// Gradients that the field has fetched with its values.

import slot::field::Place;

fn field_gradient(place: Place) -> vec3f { return place.gradient; }
