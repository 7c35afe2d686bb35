// Extinction by the magnitude of the gradient in the middle of a slab.

import generated::gradient_magnitude::params;
import package::sample::Sample;
import slot::field::locate;
import slot::gradient::field_gradient;

fn weight(front: Sample, back: Sample, slab_length: f32) -> f32 {
  // Divided first, since squares of very large and very small gradients do not fit into 32 bits.
  return saturate(length(field_gradient(locate(mix(front.p_index, back.p_index, 0.5))) / params.full_at));
}
