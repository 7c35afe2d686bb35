// A slice of cells further away from a light: what came through to the slice before it, times what comes through between.

import generated::occlusion::params as occlusion;
import generated::pass::{occluders, occluders_sampler, shadow_slices, shadows_out};
import generated::shadow::params as shadow;
import package::shadow_cells::{middle_of, to_light};
import package::ways::{held_between, stretch};

@compute @workgroup_size(16, 4, 1)
fn main(@builtin(global_invocation_id) id: vec3u) {
  let cells = occlusion.cells + 2u;
  let u = (shadow.axis + 1u) % 3u;
  let v = (shadow.axis + 2u) % 3u;
  var texel = vec3u(shadow.slice);
  texel[u] = id.x;
  texel[v] = id.y;
  if (any(texel >= cells)) { return; }
  let middle = middle_of(texel);
  let direction = to_light(middle);
  let pace = direction[shadow.axis] * shadow.towards;
  // A way reaches to the slice before. Where it leaves the volume on it, all light arrives there.
  let way = direction / max(pace, 1e-6);
  let met = stretch(middle, way, shadow.low, shadow.high);
  let is_dimmed = pace > 0.0 && met.x < met.y;
  let before = middle + way;
  let came = select(vec3f(1.0), arrived(vec2f(before[u], before[v]) + 0.5, vec2u(cells[u], cells[v])), met.y > 1.0);
  let end = min(met.y, 1.0);
  let here = select(vec3f(1.0), came * through(middle, way, min(met.x, end), end), is_dimmed);
  shadow_slices[(u32(shadow.is_odd != 0u) * cells[v] + id.y) * cells[u] + id.x] = vec4f(here, 0.0);
  textureStore(shadows_out, texel + vec3u(0u, 0u, shadow.stack_z), vec4f(here, 1.0));
}

fn through(p_cell: vec3f, way: vec3f, begin: f32, end: f32) -> vec3f {
  let held = held_between(occluders, occluders_sampler, 1.0 / vec3f(occlusion.cells), p_cell, way, begin, end);
  return exp(-held * (length(shadow.world_from_cells * way) / occlusion.cell_world));
}

// What came through to the slice before, between the middles of its cells.
fn arrived(place: vec2f, cells: vec2u) -> vec3f {
  let inside = clamp(place, vec2f(0.0), vec2f(cells) - 1.0);
  let low = min(vec2u(inside), cells - 2u);
  let share = inside - vec2f(low);
  let first = (u32(shadow.is_odd == 0u) * cells.y + low.y) * cells.x + low.x;
  let near = mix(shadow_slices[first].rgb, shadow_slices[first + 1u].rgb, share.x);
  let far = mix(shadow_slices[first + cells.x].rgb, shadow_slices[first + cells.x + 1u].rgb, share.x);
  return mix(near, far, share.y);
}
