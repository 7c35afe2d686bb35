// The number of which gradients are taken is that of the sample.

import slot::field::{Place, field_value};
import slot::values::scalar_of;

fn field_scalar(place: Place) -> f32 { return scalar_of(field_value(place)); }
