// Gradients at voxels as texels, with values beside them: see `GradientEncoding`.

import generated::encoding::params;
import slot::field::{Place, field_scalar};
import slot::gradient::field_gradient;

fn gradient_texel(place: Place) -> vec4f {
  let gradient = field_gradient(place) / params.scale;
  let cut = min(1.0, params.longest / max(length(gradient), 1e-30));
  let value = (field_scalar(place) - params.value_offset) / params.value_scale;
  return vec4f(gradient * cut, select(value, 0.0, params.value_scale == 0.0));
}
