// Extinction by how much the value changes along the ray.

import generated::change::params;
import package::sample::Sample;
import slot::values::scalar_of;

fn weight(front: Sample, back: Sample, length: f32) -> f32 {
  return saturate(abs(scalar_of(back.value) - scalar_of(front.value)) / max(length * params.full_at, 1e-30));
}
