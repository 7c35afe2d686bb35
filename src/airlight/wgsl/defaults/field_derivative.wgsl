// A field that does not tell its derivative; the host refuses the gradient stage that asks for it.

import slot::field::Place;

fn field_derivative(place: Place) -> vec3f { return vec3f(0.0); }
