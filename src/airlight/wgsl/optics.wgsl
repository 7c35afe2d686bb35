// Emission and absorption over a slab.

import package::sample::Slab;

// (1 - exp(-x)) / x, without loss where x is small; x at least 0.
fn mean_transmittance(x: f32) -> f32 {
  let series = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0)));
  return select((1.0 - exp(-x)) / x, series, x < 0.02);
}

// Slab of a medium with mean extinction [1/world] whose source [1/world] is already weighted by its attenuation.
// The colour is split between the ends as that of a homogeneous medium: the back's share is
// (1 - (1 + x) exp(-x)) / (x (1 - exp(-x))) with x the optical depth.
fn make_slab(source: vec3f, extinction: f32, length: f32) -> Slab {
  let depth = extinction * length;
  let through = mean_transmittance(depth);
  let alpha = depth * through;
  let rgb = source * (length * through);
  let back = select((1.0 - (1.0 - alpha) * (1.0 + depth)) / (depth * alpha), 0.5 - depth / 12.0, depth < 0.02);
  return Slab(rgb * (1.0 - back), alpha * (1.0 - back), rgb * back, alpha * back, alpha);
}

// The near slab in front of the far one, as one slab: both keep their split.
fn over(near: Slab, far: Slab) -> Slab {
  let through = 1.0 - near.alpha;
  return Slab(
    near.front_rgb + through * far.front_rgb,
    near.front_specular + through * far.front_specular,
    near.back_rgb + through * far.back_rgb,
    near.back_specular + through * far.back_specular,
    near.alpha + through * far.alpha,
  );
}
