// Central differences.

import slot::field::Place;
import package::gradient::difference::{difference, gradient_world};

fn field_gradient(place: Place) -> vec3f {
  let p = place.p_index;
  return gradient_world(vec3f(
    difference(p, vec3f(1.0, 0.0, 0.0)),
    difference(p, vec3f(0.0, 1.0, 0.0)),
    difference(p, vec3f(0.0, 0.0, 1.0)),
  ));
}
