// A piece of a medium between two values, light attenuated by the piece as a whole alone.

import generated::transfer::params;
import package::sample::Slab;
import package::transfer::cells::Reached;
import package::transfer::straight::{mean_between, lengths_of, homogeneous, with_ends};

fn between(s_front: f32, front: Reached, s_back: f32, back: Reached, length: f32) -> Slab {
  let lengths = lengths_of(s_front, front, s_back, back, length);
  return with_ends(front, homogeneous(mean_between(front, back, params.per_value), lengths.y), back, lengths);
}
