// One evaluation of light for the whole slab: where its light comes from on the mean, in its middle, or at its front.

import generated::sampled::AT;
import generated::sizes::{GROUPS, SURFACES_ONLY};
import package::ray::Ray;
import package::sample::{Sample, Slab};
import package::lighting::at_share::lit_at;
import slot::field::{locate, field_value};
import slot::values::scalar_of;

fn light_slab(front: Sample, back: Sample, slab: Slab, ray: Ray) -> vec3f {
  if (AT != 0u) { return lit_at(front, back, select(0.0, 0.5, AT == 1u), slab, ray); }
  return lit_at(front, back, lit_place(front, back, centre_of(slab)), slab, ray);
}

// Mean place of a slab's light, colour and highlights alike, as a share of the way from its front to its back.
fn centre_of(slab: Slab) -> f32 {
  let front = dot(slab.front_rgb, vec3f(1.0)) + slab.front_specular;
  let back = dot(slab.back_rgb, vec3f(1.0)) + slab.back_specular;
  return select(0.5, back / (front + back), front + back > 0.0);
}

// Share of a value that rounding does not reach.
const TOLD = 1e-4;

// Classification takes the field to run straight from end to end. Where it does not, the value that light comes from lies elsewhere:
// between the sample at that share and one of the ends. Ends that are all but equal tell nothing of it, nor do several channels, and
// a surface lies where it lies.
fn lit_place(front: Sample, back: Sample, share: f32) -> f32 {
  if (GROUPS > 0u || SURFACES_ONLY) { return share; }
  let a = scalar_of(front.value);
  let b = scalar_of(back.value);
  let wanted = mix(a, b, share);
  let off = scalar_of(field_value(locate(mix(front.p_index, back.p_index, share)))) - wanted;
  let is_passed = (off > 0.0) == (b > a);
  let rest = abs(select(b - wanted, wanted - a, is_passed));
  let part = abs(off) / max(rest + abs(off), 1e-30);
  let moved = part * select(1.0 - share, -share, is_passed);
  let told = max(max(abs(off), TOLD * max(abs(a), abs(b))), 1e-30);
  return share + moved * saturate(8.0 * abs(b - a) / told);
}
