// Gradients of a layer that is chosen by its number.

import generated::frame::frame;
import next::several::gradients::{densest as rest_densest, gradient_of_layer as rest_gradient_of_layer};
import package::faces::face_gradient;
import package::several::gradients_end::Dense;
import package::several::layer::Lines;
import package::walk::{fetch, sample_of};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::region::part_at;
import slot::transfer::classify;
import slot::values::is_gap;

// Of the face of a clip, if one cuts there.
fn gradient_of_layer(lines: Lines, number: u32, clip: u32, t_world: f32) -> vec3f {
  if (number > 0u) { return rest_gradient_of_layer(lines.rest, number - 1u, clip, t_world); }
  let ray = lines.own.ray;
  if (clip > 0u) { return face_gradient(clip, ray.origin_world + t_world * ray.direction_world); }
  return field_gradient(locate(lines.own.index.origin + t_world * lines.own.index.direction));
}

// The layer that is most opaque at a distance, the first of equal ones.
fn densest(lines: Lines, t_world: f32) -> Dense {
  let rest = rest_densest(lines.rest, t_world);
  let here = sample_of(lines.own, fetch(lines.own, t_world));
  let is_there = lines.own.enter <= t_world && t_world <= lines.own.leave && !is_gap(here.value);
  let alpha = classify(here, here, frame.step_world * part_at(here.p_index).opacity).alpha;
  let own = select(-1.0, alpha, is_there);
  if (own >= rest.alpha) { return Dense(own, 0u); }
  return Dense(rest.alpha, rest.number + 1u);
}
