// Functions of regions: the medium of a value in a place.

import generated::transfer::{params, ASSOCIATED};
import package::sample::{Sample, Medium};
import package::transfer::axes::axis_of;
import package::transfer::cells::{function_count, medium_on, source_of};
import slot::region::shares_at;

fn region_medium(here: Sample) -> Medium {
  let shares = shares_at(here.p_index);
  var sum = vec4f(0.0);
  for (var number = 0u; number < function_count(); number++) {
    let medium = medium_on(axis_of(number), here.value);
    sum += vec4f(source_of(medium), medium.extinction) * shares.by_function[number];
  }
  return Medium(select(sum.rgb / max(sum.a, 1e-37), sum.rgb, ASSOCIATED), sum.a);
}

// Whether both values lie on one of the (at most four) stretches on which no function holds anything.
fn is_empty_in_all(s_front: f32, s_back: f32) -> bool {
  let low = vec4f(min(s_front, s_back));
  let high = vec4f(max(s_front, s_back));
  return any((low >= params.empty_low) & (high <= params.empty_high));
}
