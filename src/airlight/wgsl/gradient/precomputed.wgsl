// Gradients that were computed at the voxels, interpolated.

import generated::precomputed::{gradients, gradients_sampler, params};
import generated::layer::layer;
import slot::field::Place;

fn field_gradient(place: Place) -> vec3f {
  let p_unit = (place.p_index + 0.5) * layer.inverse_size;
  return textureSampleLevel(gradients, gradients_sampler, p_unit, 0.0).xyz * params.scale;
}
