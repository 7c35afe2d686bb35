// Reinhard's global operator on luminance.

import generated::reinhard::params;
import generated::luminance::params as scene;
import package::colour::luminance;
import package::tone::metered::{compressed, exposed};

fn tone(rgb: vec3f, p_px: vec2f) -> vec3f {
  let scale = exposed(params.exposure, params.key, params.adapted, scene.log_average);
  return select(rgb, rgb * scale * compressed(scale * luminance(rgb), params.white), scale > 0.0);
}
