// Ambient, diffuse and specular light at a normal.

import generated::blinn_phong::params;
import generated::lights::lights;
import generated::sizes::LIGHTS;
import package::lights::{arriving, surfaceness};
import package::sample::{Sample, Lit};
import slot::visibility::{visibility, ambient_visibility};

fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit {
  var lit = Lit(vec3f(params.ambient * ambient_visibility(here.p_world)), vec3f(0.0));
  let surface = surfaceness(here.gradient, params.per_threshold);
  if (surface <= 0.0) { return lit; }
  for (var i = 0u; i < LIGHTS; i++) {
    let from_light = arriving(lights[i], here.p_world, to_eye);
    let radiance = surface * from_light.rgb * visibility(i, here.p_world);
    let n_l = facing(dot(normal, from_light.to_light));
    let n_h = facing(dot(normal, normalize(from_light.to_light + to_eye)));
    lit.diffuse += radiance * (params.diffuse * n_l);
    lit.specular += select(vec3f(0.0), radiance * (params.specular * pow(n_h, params.shininess)), n_l > 0.0 && n_h > 0.0);
  }
  return lit;
}

// Cosine of an angle at a surface that has two sides or one.
fn facing(cosine: f32) -> f32 { return select(max(cosine, 0.0), abs(cosine), params.two_sided != 0u); }
