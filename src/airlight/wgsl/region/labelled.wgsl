// The styles of the eight labels round a place, mixed by their trilinear weights: tints also by opacity.

import generated::region::{params, cells, styles, ALONE, OWN_FUNCTIONS};
import package::sample::Part;

const ROW = 1024u;
const MOST_FUNCTIONS = 16u;

fn part_at(p_index: vec3f) -> Part {
  // Functions of regions see to it themselves.
  if (OWN_FUNCTIONS) { return Part(vec3f(1.0), 1.0); }
  let mixed = mixed_at(p_index);
  let rgb = mixed.tinted.rgb / max(mixed.tinted.a, 1e-30);
  // Without an image the field itself is what regions take.
  if (ALONE) { return Part(rgb, mixed.tinted.a / max(mixed.taken, 1e-30)); }
  return Part(rgb, mixed.tinted.a);
}

// Whether nothing is drawn, told at once: where labels differ it is left to `part_at`.
fn hidden_at(p_index: vec3f) -> bool {
  let cell = textureLoad(cells, vec3u(voxels_round(p_index).low), 0).x;
  return (cell & 1u) == 0u && style_of(cell >> 1u).tinted.a == 0.0;
}

// Tint times opacity, and opacity; and the share of what is drawn at all.
struct Mixed { tinted: vec4f, taken: f32 }

// Where all eight labels are one the loop ends after a turn.
fn mixed_at(p_index: vec3f) -> Mixed {
  var corner = first_corner(voxels_round(p_index));
  var sum = Mixed(vec4f(0.0), 0.0);
  loop {
    let tinted = style_of(corner.label).tinted;
    sum.tinted += corner.share * tinted;
    sum.taken += select(0.0, corner.share, tinted.a > 0.0);
    if (!next_corner(&corner)) { break; }
  }
  return sum;
}

// The same for each function by itself.
struct Shares { by_function: array<vec4f, MOST_FUNCTIONS> }

fn shares_at(p_index: vec3f) -> Shares {
  var corner = first_corner(voxels_round(p_index));
  var shares: Shares;
  loop {
    let style = style_of(corner.label);
    shares.by_function[style.number] += corner.share * style.tinted;
    if (!next_corner(&corner)) { break; }
  }
  return shares;
}

// The lowest of the eight texels round a place, and how far the place lies from it.
struct Voxels { low: vec3f, within: vec3f }

fn voxels_round(p_index: vec3f) -> Voxels {
  let p = clamp((params.texel_from_index * vec4f(p_index, 1.0)).xyz, vec3f(0.0), params.last_texel);
  let low = min(floor(p), params.last_texel - 1.0);
  return Voxels(low, p - low);
}

struct Corner { place: Voxels, number: u32, count: u32, label: u32, share: f32 }

fn first_corner(place: Voxels) -> Corner {
  let cell = textureLoad(cells, vec3u(place.low), 0).x;
  let is_mixed = (cell & 1u) == 1u;
  let w = 1.0 - place.within;
  return Corner(place, 0u, select(1u, 8u, is_mixed), cell >> 1u, select(1.0, w.x * w.y * w.z, is_mixed));
}

fn next_corner(corner: ptr<function, Corner>) -> bool {
  let number = (*corner).number + 1u;
  if (number >= (*corner).count) { return false; }
  let high = vec3u(number, number >> 1u, number >> 2u) & vec3u(1u);
  let place = (*corner).place;
  let w = mix(1.0 - place.within, place.within, vec3f(high));
  let cell = textureLoad(cells, vec3u(place.low) + high, 0).x;
  (*corner) = Corner(place, number, (*corner).count, cell >> 1u, w.x * w.y * w.z);
  return true;
}

// The style of a label, and the number of its function.
struct Style { tinted: vec4f, number: u32 }

fn style_of(label: u32) -> Style {
  let kept = textureLoad(styles, vec3u(label, label / ROW, label / (ROW * ROW)) % ROW, 0);
  if (!OWN_FUNCTIONS) { return Style(kept, 0u); }
  let number = floor(0.5 * kept.a);
  return Style(vec4f(kept.rgb, kept.a - 2.0 * number), u32(number));
}
