// Values on a stretch on which the function holds nothing stay on it when they are put right for curvature: the field does not leave
// it there, and what is skipped or not must not differ.

import generated::transfer::params;

fn held_on_stretch(found: f32, moved: f32) -> f32 {
  let on = (vec4f(found) >= params.empty_low) & (vec4f(found) <= params.empty_high);
  let low = select(vec4f(-3.4e38), params.empty_low, on);
  let high = select(vec4f(3.4e38), params.empty_high, on);
  return clamp(moved, max(max(low.x, low.y), max(low.z, low.w)), min(min(high.x, high.y), min(high.z, high.w)));
}
