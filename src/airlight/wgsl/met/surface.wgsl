// The surface at which a ray ends, where surfaces are looked for.

import generated::driver::REFINE;
import generated::sizes::{LIGHTS_FACES, WALKS_CELLS};
import package::faces::{Face, lit_behind};
import package::front::{Front, lit_sheet};
import package::kept::Kept;
import package::met::Met;
import package::refine::refined;
import package::sample::{Sample, Slab};
import package::walk::{Line, fetch, sample_of};
import slot::integrate::{Accumulated, level, surface, surface_rgb, take};
import slot::region::part_at;
import slot::transfer::medium;
import slot::values::{mix_values, scalar_of, with_scalar};

// The surface within a slab, where at least half of its region is drawn: opacity runs straight from end to end. The share at which
// it lies, and 1 where the field passes its value there, not the border of a region.
fn shown_surface(front: Sample, back: Sample) -> vec2f {
  let share = surface(front, back);
  if (share > 1.0) { return vec2f(share, 0.0); }
  let opacity = vec2f(part_at(front.p_index).opacity, part_at(back.p_index).opacity);
  if (mix(opacity.x, opacity.y, share) >= 0.5) { return vec2f(share, 1.0); }
  if (opacity.y < 0.5) { return vec2f(2.0, 0.0); }
  let begin = (0.5 - opacity.x) / (opacity.y - opacity.x);
  var here = front;
  here.value = mix_values(front.value, back.value, begin);
  return vec2f(select(2.0, begin, surface(here, back) <= 0.0), 0.0);
}

// The sample there, as a slab without length.
fn take_surface(
  acc: ptr<function, Accumulated>, line: Line, front: Sample, back: Sample, shown: vec2f, kept: Kept, face: Face,
) -> Met {
  let share = shown.x;
  var t_world = mix(front.t_world, back.t_world, share);
  // What a ray begins in, and what a region's border uncovers, lies where it lies.
  let refines = REFINE > 0u && share > 0.0 && shown.y > 0.0;
  if (refines && WALKS_CELLS) { t_world = back.t_world; }
  if (refines && !WALKS_CELLS) {
    let near = vec2f(front.t_world, scalar_of(front.value));
    let far = vec2f(back.t_world, scalar_of(back.value));
    t_world = refined(line.index.origin, line.index.direction, near, far, level(front, back));
  }
  var hit = sample_of(line, fetch(line, t_world));
  if (refines) {
    hit.value = with_scalar(hit.value, level(front, back));
  } else {
    hit.value = mix_values(front.value, back.value, share);
  }
  var rgb = medium(hit).rgb;
  if (share > 0.0) { rgb = surface_rgb(hit, front, back, rgb); }
  rgb *= part_at(hit.p_index).rgb;
  let slab = Slab(rgb, 1.0, vec3f(0.0), 0.0, 1.0);
  var end: Front;
  var lit_rgb = lit_sheet(&end, hit, slab, line.ray);
  if (LIGHTS_FACES) { lit_rgb = lit_behind(face, slab, hit, hit, lit_rgb); }
  take(acc, hit, hit, slab, lit_rgb, 0.0);
  let side = select(2.0, 1.0, scalar_of(back.value) > scalar_of(front.value));
  let is_cut = share <= 0.0 && t_world <= kept.begin;
  return Met(scalar_of(hit.value), select(side, 3.0, share <= 0.0), select(0u, kept.near, is_cut), 0u);
}
