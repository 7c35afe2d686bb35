// Numbers of the directions nearest to the normals of voxels.

import generated::layer::layer;
import generated::lighting::normals;
import generated::steep::params as steep;
import slot::field::locate;
import slot::gradient::field_gradient;

// Of four voxels along x.
fn four_numbers(texel: vec3u) -> vec4u {
  var numbers = vec4u(0u);
  for (var i = 0u; i < 4u; i++) {
    numbers[i] = number_of(field_gradient(locate(min(vec3f(vec3u(4u * texel.x + i, texel.yz)), layer.size - 1.0))));
  }
  return numbers;
}

// Counted from 1; 0 where the gradient is too weak.
fn number_of(gradient: vec3f) -> u32 {
  var best = vec2f(0.0, -3e38);
  for (var number = 0u; number < textureDimensions(normals).x; number++) {
    let nearness = -dot(gradient, textureLoad(normals, vec3u(number, 0u, 0u), 0).xyz);
    if (nearness > best.y) { best = vec2f(f32(number + 1u), nearness); }
  }
  return select(0u, u32(best.x), length(gradient) > steep.threshold);
}
