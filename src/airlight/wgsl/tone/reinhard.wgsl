// Reinhard's global operator on luminance.

import generated::reinhard::params;
import generated::luminance::params as scene;
import package::colour::luminance;

fn tone(rgb: vec3f, p_px: vec2f) -> vec3f {
  let bright = luminance(rgb);
  if (bright <= 0.0 || scene.log_average <= 0.0) { return rgb; }
  let scaled = exp2(params.exposure) * params.key / scene.log_average * bright;
  let shown = scaled * (1.0 + scaled / (params.white * params.white)) / (1.0 + scaled);
  return rgb * (shown / bright);
}
