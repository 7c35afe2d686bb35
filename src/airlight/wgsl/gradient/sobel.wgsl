// Central differences, smoothed across by the weights 1, 2, 1 in both other directions.
// The bounds of the loops are not known to compilers, so that they stay loops: unrolled, they are 54 samples long.

import slot::field::Place;
import generated::layer::layer;
import package::gradient::difference::{known_difference, gradient_world};

fn field_gradient(place: Place) -> vec3f {
  var gradient = vec3f(0.0);
  for (var i = 0u; i < layer.axes; i++) {
    let axis = select(vec3f(0.0), vec3f(1.0), vec3u(0u, 1u, 2u) == vec3u(i));
    var sum = vec2f(0.0);
    for (var neighbour = 0u; neighbour < layer.axes * layer.axes; neighbour++) {
      let u = f32(neighbour % layer.axes) - 1.0;
      let v = f32(neighbour / layer.axes) - 1.0;
      let p_index = place.p_index + u * axis.zxy + v * axis.yzx;
      let weight = (2.0 - abs(u)) * (2.0 - abs(v));
      sum += weight * known_difference(clamp(p_index, layer.domain_low, layer.domain_high), axis);
    }
    gradient += sum.x / max(sum.y, 1.0) * axis;
  }
  return gradient_world(gradient);
}
