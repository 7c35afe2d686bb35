// How tones are exposed by what was measured of the picture.

const LEAST_AVERAGE: f32 = 1e-6;

// What light is multiplied by; 0 where the average is not known, since nothing is covered.
fn exposed(exposure: f32, key: f32, adapted: f32, measured: f32) -> f32 {
  let average = select(measured, adapted, adapted > 0.0);
  return select(0.0, exp2(exposure) * key / max(average, LEAST_AVERAGE), average > 0.0);
}

// Reinhard's curve over what is mapped: by what light is multiplied where it is as bright as `bright`.
fn compressed(bright: f32, white: f32) -> f32 { return (1.0 + bright / (white * white)) / (1.0 + bright); }
