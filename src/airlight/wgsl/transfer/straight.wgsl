// A slab along which the value runs straight from one end to the other: what the function's integral says of it.

import generated::transfer::OPEN_ENDS;
import package::optics::{make_slab, over, placed};
import package::sample::Slab;
import package::transfer::cells::{Axis, Reached, reach_on};

const NEAR: f32 = 1e-5;  // share of the axis: closer values are told apart by too few digits

// Mean source and mean extinction [1/world], over the part of the slab whose values lie on the axis.
fn mean_between(front: Reached, back: Reached, per_value: f32) -> vec4f {
  let way = (back.value - front.value) * per_value;
  let difference = (back.high - front.high) + (back.low - front.low);
  return max(select(0.5 * (front.here + back.here), difference / way, abs(way) > NEAR), vec4f(0.0));
}

// Beyond its ends the function is constant: how much of a slab's length lies before, within and behind its axis.
fn lengths_of(s_front: f32, front: Reached, s_back: f32, back: Reached, length: f32) -> vec3f {
  let per_value = select(0.0, length / abs(s_back - s_front), s_front != s_back);
  // A slab of one value lies wholly on the axis, or wholly before it.
  let is_outside = s_front == s_back && front.value != s_front;
  let before = select(min(abs(front.value - s_front) * per_value, length), length, is_outside);
  let after = min(abs(s_back - back.value) * per_value, length - before);
  return vec3f(before, max(length - before - after, 0.0), after);
}

fn homogeneous(medium: vec4f, length: f32) -> Slab { return make_slab(medium.rgb, medium.a, length); }

// The slab within the axis between those beyond its ends, which mostly hold nothing.
fn with_ends(front: Reached, inside: Slab, back: Reached, lengths: vec3f) -> Slab {
  let ends = vec2f(lengths.x, lengths.x + lengths.y) / max(lengths.x + lengths.y + lengths.z, 1e-30);
  let within = placed(inside, ends.x, ends.y);
  if (!OPEN_ENDS) { return within; }
  let before = placed(homogeneous(front.here, lengths.x), 0.0, ends.x);
  let after = placed(homogeneous(back.here, lengths.z), ends.y, 1.0);
  return over(before, over(within, after));
}

// Mean source and extinction [1/world] of one function, of what lies beyond its ends, too.
fn mean_along(axis: Axis, s_front: f32, s_back: f32) -> vec4f {
  let front = reach_on(axis, s_front);
  let back = reach_on(axis, s_back);
  let shares = lengths_of(s_front, front, s_back, back, 1.0);
  return shares.x * front.here + shares.y * mean_between(front, back, axis.per_value) + shares.z * back.here;
}
