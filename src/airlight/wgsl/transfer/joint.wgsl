// A function of two or three variables: values of channels, gradient magnitude, second derivative along the gradient.

import generated::transfer::{params, shapes, shapes_sampler, ASSOCIATED, CUTS_SLABS, HAS_GRADIENT, HAS_SECOND};
import package::gradient::second::second_along;
import package::optics::{make_slab, over, placed};
import package::sample::{Sample, Medium, Slab};
import slot::field::locate;
import slot::gradient::field_gradient;
import slot::lookup::table_at;
import slot::values::channel_of;

// What is no channel has these numbers, as in `stages/transfer_joint.py`.
const GRADIENT = 16u;
const SECOND = 17u;

// Where a sample lies on the axes, from 0 to 1 within them, and source and extinction there [1/world].
struct Known { place: vec3f, here: vec4f }

fn know(here: Sample) -> Known {
  let place = place_on_axes(here);
  return Known(place, source_at(place));
}

fn know_empty(here: Sample) -> Known { return know(here); }

fn medium(here: Sample) -> Medium {
  let found = source_at(place_on_axes(here));
  return Medium(select(found.rgb / max(found.a, 1e-37), found.rgb, ASSOCIATED), found.a);
}

fn place_on_axes(here: Sample) -> vec3f {
  var steepness = 0.0;
  var second = 0.0;
  if (HAS_GRADIENT) {
    let gradient = field_gradient(locate(here.p_index));
    steepness = length(gradient);
    if (HAS_SECOND) { second = second_along(here.p_index, gradient); }
  }
  var variables = vec3f(0.0);
  for (var i = 0u; i < 3u; i++) {
    let kind = params.variables[i];
    let value = channel_of(here.value, select(kind, 0u, kind >= GRADIENT));
    variables[i] = select(select(value, steepness, kind == GRADIENT), second, kind == SECOND);
  }
  return (variables - params.low) * params.per_variable;
}

fn source_at(place: vec3f) -> vec4f {
  let inside = all((place >= vec3f(0.0)) & (place <= vec3f(1.0)));
  let found = table_at(shapes, shapes_sampler, (place * (params.entries - 1.0) + 0.5) / params.entries);
  return select(vec4f(0.0), found, inside);
}

// Whether both values of the first variable lie on one of the stretches on which there are no shapes.
fn empty_slab(front: Sample, back: Sample) -> bool {
  let a = channel_of(front.value, params.variables.x);
  let b = channel_of(back.value, params.variables.x);
  return any((vec4f(min(a, b)) >= params.empty_low) & (vec4f(max(a, b)) <= params.empty_high));
}

fn classify(front: Sample, back: Sample, length: f32) -> Slab {
  return classify_known(front, know(front), back, know(back), length);
}

// Without further samples a slab is the mean of its ends. With them the variables run straight from end to end, and a slab is cut
// into as many pieces as the way is long in entries of the table, as far as there are samples.
fn classify_known(front: Sample, front_known: Known, back: Sample, back_known: Known, length: f32) -> Slab {
  if (!CUTS_SLABS) {
    let mean = 0.5 * (front_known.here + back_known.here);
    return make_slab(mean.rgb, mean.a, length);
  }
  let way = back_known.place - front_known.place;
  let entries = abs(way) * (params.entries - 1.0);
  let pieces = clamp(ceil(max(entries.x, max(entries.y, entries.z))), 1.0, f32(params.samples));
  var slab = Slab(vec3f(0.0), 0.0, vec3f(0.0), 0.0, 0.0);
  for (var piece = 0.0; piece < pieces; piece += 1.0) {
    let here = source_at(front_known.place + way * ((piece + 0.5) / pieces));
    slab = over(slab, placed(make_slab(here.rgb, here.a, length / pieces), piece / pieces, (piece + 1.0) / pieces));
  }
  return slab;
}
