// Central differences, smoothed across by the weights 1, 2, 1 in both other directions.
// The bound of the loop is not known to compilers, so that it stays a loop: unrolled it is 54 samples long. Nor is it told by a
// uniform: software devices would compile it anew for each dispatch.

import slot::field::Place;
import generated::layer::layer;
import package::gradient::difference::{known_difference, gradient_world};

fn field_gradient(place: Place) -> vec3f {
  var sum = vec3f(0.0);
  var known = vec3f(0.0);
  let neighbours = select(9u, 0u, place.p_index.x > 1e30);
  for (var neighbour = 0u; neighbour < neighbours; neighbour++) {
    let u = f32(neighbour % 3u) - 1.0;
    let v = f32(neighbour / 3u) - 1.0;
    let weight = (2.0 - abs(u)) * (2.0 - abs(v));
    let x = known_difference(inside(place.p_index + vec3f(0.0, u, v)), vec3f(1.0, 0.0, 0.0));
    let y = known_difference(inside(place.p_index + vec3f(v, 0.0, u)), vec3f(0.0, 1.0, 0.0));
    let z = known_difference(inside(place.p_index + vec3f(u, v, 0.0)), vec3f(0.0, 0.0, 1.0));
    sum += weight * vec3f(x.x, y.x, z.x);
    known += weight * vec3f(x.y, y.y, z.y);
  }
  return gradient_world(sum / max(known, vec3f(1.0)));
}

fn inside(p_index: vec3f) -> vec3f { return clamp(p_index, layer.domain_low, layer.domain_high); }
