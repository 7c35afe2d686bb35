// The transfer function of a layer with one.

import generated::transfer::params;
import package::sample::Medium;
import package::transfer::cells::{Axis, Reached, medium_on, reach_on};

fn axis_of_function() -> Axis {
  return Axis(
    0u, params.first_value, params.last_value, params.per_value, params.even_cells, params.first_medium, params.last_medium,
  );
}

fn function_at(value: f32) -> Medium { return medium_on(axis_of_function(), value); }

fn reach(value: f32) -> Reached { return reach_on(axis_of_function(), value); }

// What is known of a value on an empty stretch, where nothing is and the integral does not grow.
fn reach_empty(value: f32) -> Reached {
  let held = clamp(value, params.first_value, params.last_value);
  let on = (vec4f(value) >= params.empty_low) & (vec4f(value) <= params.empty_high);
  let which = select(vec4f(0.0), vec4f(1.0), on);
  return Reached(held, vec4f(0.0), params.empty_integral_high * which, params.empty_integral_low * which);
}

// Whether both values lie on one of the (at most four) stretches on which the function holds nothing.
fn is_empty_between(s_front: f32, s_back: f32) -> bool {
  let low = vec4f(min(s_front, s_back));
  let high = vec4f(max(s_front, s_back));
  return any((low >= params.empty_low) & (high <= params.empty_high));
}
