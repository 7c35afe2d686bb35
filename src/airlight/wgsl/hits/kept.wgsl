// What was found at surfaces is kept for light that comes later: gradient and value; distance and which side was met.

import generated::pass::hits;

const KEEPS_HITS = true;

fn keep_hit(pixel: u32, shape: vec4f, place: vec4f) {
  hits[2u * pixel] = shape;
  hits[2u * pixel + 1u] = place;
}
