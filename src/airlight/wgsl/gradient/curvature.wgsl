// Curvatures of the surface of equal value through a point (Kindlmann et al. 2003), from gradients on all sides of it.

import generated::layer::layer;
import slot::field::locate;
import slot::gradient::field_gradient;

const APART = 0.5;  // [voxel]

// The greater and the lesser principal curvature [1/world]; positive where the surface is round like a ball of high values.
fn curvatures(p_index: vec3f) -> vec2f {
  let gradient = field_gradient(locate(p_index));
  let steepness = length(gradient);
  if (steepness <= 0.0) { return vec2f(0.0); }
  let change = mat3x3f(
    change_along(p_index, vec3f(APART, 0.0, 0.0)),
    change_along(p_index, vec3f(0.0, APART, 0.0)),
    change_along(p_index, vec3f(0.0, 0.0, APART)),
  );
  // Second derivatives in the world, put right for how the differences are not symmetric.
  let turned = change * transpose(layer.gradient_world_from_index);
  let hessian = 0.5 * (turned + transpose(turned));
  // The change of the normal along the surface.
  let normal = gradient / steepness;
  let n = mat3x3f(normal * normal.x, normal * normal.y, normal * normal.z);
  let flat = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0)) - n;
  let bent = flat * hessian * flat * (-1.0 / steepness);
  let trace = bent[0].x + bent[1].y + bent[2].z;
  let squares = dot(bent[0], bent[0]) + dot(bent[1], bent[1]) + dot(bent[2], bent[2]);
  let apart = sqrt(max(2.0 * squares - trace * trace, 0.0));
  return 0.5 * vec2f(trace + apart, trace - apart);
}

// Change of the gradient along an index axis [data/world/voxel].
fn change_along(p_index: vec3f, way: vec3f) -> vec3f {
  let low = max(p_index - way, layer.domain_low);
  let high = min(p_index + way, layer.domain_high);
  return (field_gradient(locate(high)) - field_gradient(locate(low))) / max(length(high - low), 1e-30);
}
