// Reinhard's local operator: his curve by the luminance round a pixel.

import generated::reinhard_local::params;
import generated::luminance::params as scene;
import package::colour::luminance;
import package::surround::surround_at;
import package::tone::metered::{compressed, exposed};

fn tone(rgb: vec3f, p_px: vec2f) -> vec3f {
  let scale = exposed(params.exposure, params.key, params.adapted, scene.log_average);
  let mapped = rgb * scale * compressed(scale * surround_at(p_px, luminance(rgb)), params.white);
  return select(rgb, mapped, scale > 0.0);
}
