// Values of all layers put right for how their fields curve along the ray.

import generated::sizes::Values;
import next::several::layer::curve;
import package::walk::Fetched;

fn curved_value(before: Fetched, here: Fetched, after: Fetched) -> Values { return curve(before.value, here.value, after.value); }
