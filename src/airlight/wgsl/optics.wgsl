// Emission and absorption over a slab.

import package::sample::Slab;

// (1 - exp(-x)) / x, without loss where x is small; x at least 0.
fn mean_transmittance(x: f32) -> f32 {
  let series = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0 - x / 5040.0)))));
  return select((1.0 - exp(-x)) / x, series, x < 0.4);
}

// How far attenuation moves the light of a homogeneous slab of this depth from its middle towards its front, as a share of its
// length: 1/2 - [1 - (1 + x) exp(-x)] / [x (1 - exp(-x))].
fn moved(depth: f32) -> f32 {
  let x = max(depth, 0.05);
  let through = exp(-x);
  let exact = 0.5 - (1.0 - through * (1.0 + x)) / (x * (1.0 - through));
  return select(exact, depth * (1.0 / 12.0 - depth * depth / 720.0), depth < 0.5);
}

// Slab of a medium with mean extinction [1/world] whose source [1/world] is already weighted by its attenuation.
// The colour is split between the ends as that of a homogeneous medium.
fn make_slab(source: vec3f, extinction: f32, length: f32) -> Slab {
  let depth = extinction * length;
  let through = mean_transmittance(depth);
  let alpha = depth * through;
  let rgb = source * (length * through);
  let back = 0.5 - moved(depth);
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

// The same slab with these shares (colour, specular) of its light at the back.
fn split(slab: Slab, back: vec4f) -> Slab {
  let rgb = slab.front_rgb + slab.back_rgb;
  return Slab(rgb * (1.0 - back.rgb), slab.alpha * (1.0 - back.a), rgb * back.rgb, slab.alpha * back.a, slab.alpha);
}

// The same slab with its colours multiplied; highlights stay white.
fn tinted(slab: Slab, rgb: vec3f) -> Slab {
  return Slab(slab.front_rgb * rgb, slab.front_specular, slab.back_rgb * rgb, slab.back_specular, slab.alpha);
}

// A piece that begins and ends at these shares of a slab, split between the ends of the whole.
fn placed(piece: Slab, begin: f32, end: f32) -> Slab {
  return Slab(
    piece.front_rgb * (1.0 - begin) + piece.back_rgb * (1.0 - end),
    piece.front_specular * (1.0 - begin) + piece.back_specular * (1.0 - end),
    piece.front_rgb * begin + piece.back_rgb * end,
    piece.front_specular * begin + piece.back_specular * end,
    piece.alpha,
  );
}

// What gets through when the thickness is multiplied. What is opaque stays so.
fn thicker(through: f32, thickness: f32) -> f32 {
  return select(select(pow(through, thickness), 1.0, thickness <= 0.0), through, thickness == 1.0);
}
