// Colour and extinction of the transfer function at a voxel, for tables of them.

import generated::classify::params as classify;
import package::empty::EMPTY;
import package::sample::Sample;
import slot::field::{locate, field_value};
import slot::transfer::medium;
import slot::values::is_gap;

fn voxel_medium(p_index: vec3f) -> vec4f {
  let here = Sample(field_value(locate(p_index)), vec3f(0.0), p_index, vec3f(0.0), 0.0);
  let found = medium(here);
  let kept = vec4f(found.rgb * select(1.0, found.extinction, classify.weighs != 0u), found.extinction);
  return select(kept, vec4f(EMPTY), is_gap(here.value));
}
