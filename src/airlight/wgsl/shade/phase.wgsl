// Light that particles scatter towards the eye, whatever way surfaces face: Henyey and Greenstein's phase function, 1 where it is
// the same in all directions.

import generated::lights::lights;
import generated::phase::params;
import generated::sizes::LIGHTS;
import package::lights::arriving;
import package::sample::{Sample, Lit};
import slot::visibility::{visibility, ambient_visibility};

fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit {
  var diffuse = vec3f(params.ambient * ambient_visibility(here.p_world));
  for (var i = 0u; i < LIGHTS; i++) {
    let from_light = arriving(lights[i], here.p_world, to_eye);
    diffuse += params.strength * scattered(-dot(from_light.to_light, to_eye)) * from_light.rgb * visibility(i, here.p_world);
  }
  return Lit(diffuse, vec3f(0.0));
}

// By the cosine of the angle by which light changes its way.
fn scattered(cosine: f32) -> f32 {
  let g = params.forward;
  return (1.0 - g * g) / pow(max(1.0 + g * g - 2.0 * g * cosine, 1e-6), 1.5);
}
