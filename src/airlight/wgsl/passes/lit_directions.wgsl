// How each direction is lit, once a frame: by lights from far away and to an eye that all rays lead to alike, at no place.

import generated::lighting::{normals, params};
import generated::pass::lit_directions_out;
import package::sample::Sample;
import slot::camera::eye_ray;
import slot::shade::light;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
  // The first has no direction.
  let number = id.x;
  if (number > textureDimensions(normals).x) { return; }
  var normal = vec3f(0.0);
  if (number > 0u) { normal = textureLoad(normals, vec3u(number - 1u, 0u, 0u), 0).xyz; }
  var here: Sample;
  here.gradient = -normal * params.steep;
  let lit = light(here, normal, -eye_ray(vec2f(0.5)).direction_world);
  textureStore(lit_directions_out, vec3u(number, 0u, 0u), vec4f(lit.diffuse, 1.0));
  textureStore(lit_directions_out, vec3u(number, 1u, 0u), vec4f(lit.specular, 1.0));
}
