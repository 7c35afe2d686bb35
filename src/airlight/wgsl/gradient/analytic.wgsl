// The derivative of the reconstruction itself.

import slot::field::{Place, field_derivative};
import package::gradient::difference::gradient_world;

fn field_gradient(place: Place) -> vec3f { return gradient_world(field_derivative(place)); }
