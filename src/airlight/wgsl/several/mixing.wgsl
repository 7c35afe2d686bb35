// Slabs of several layers in one place, each lit by itself, as one even medium: depths add, and so do sources (decision 0017).

// Light times depth over opacity, as if nothing were attenuated, and depth.
struct Mixed { source: vec3f, depth: f32 }

// Light of the solid faces at a place, and how many there are.
struct Caps { rgb: vec3f, count: f32 }

// 32 bits do not tell how deep what is all but opaque is: as deep as a surface, so that nothing else in its place shows.
const MOST_ALPHA = 0.9999999;
const OPAQUE_DEPTH = 1e4;

// -log(1 - alpha) / alpha, without loss where there is little.
fn depth_per_alpha(alpha: f32) -> f32 {
  if (alpha >= MOST_ALPHA) { return OPAQUE_DEPTH; }
  let series = 1.0 + alpha * (0.5 + alpha * (1.0 / 3.0 + alpha * (0.25 + alpha * 0.2)));
  return select(-log(1.0 - alpha) / max(alpha, 1e-30), series, alpha < 0.04);
}
