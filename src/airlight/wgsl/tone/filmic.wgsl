// A logistic curve in the logarithm of light, of each channel.

import generated::filmic::params;
import generated::luminance::params as scene;
import package::tone::metered::exposed;

const GREY = 0.18;

fn tone(rgb: vec3f, p_px: vec2f) -> vec3f {
  let scale = exposed(params.exposure, params.key, params.adapted, scene.log_average);
  // Of peak * x^c / (x^c + half), what leaves grey as it is and makes white 1.
  let grey = pow(GREY, params.contrast);
  let white = pow(params.white, params.contrast);
  let half = (1.0 - GREY) * grey * white / (GREY * white - grey);
  let stops = params.contrast * log2(max(scale * rgb, vec3f(1e-30))) - log2(half);
  let shown = (1.0 + half / white) / (1.0 + exp2(clamp(-stops, vec3f(-120.0), vec3f(120.0))));
  return select(rgb, select(vec3f(0.0), shown, rgb > vec3f(0.0)), scale > 0.0);
}
