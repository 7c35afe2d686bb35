// What hides in a layer, and in those behind it in the list, on ways that begin among the cells of a layer that is dimmed.

import generated::hides::{params, occluders, occluders_sampler};
import next::hides::{depth_along as rest_depth_along, depth_round as rest_depth_round};
import package::ways::{held_between, stretch};

// Optical depth by colour along a way, up to so many times its length.
fn depth_along(p_cell: vec3f, way: vec3f, most: f32, way_world: f32) -> vec3f {
  let place = (params.from_cells * vec4f(p_cell, 1.0)).xyz;
  let own = (params.from_cells * vec4f(way, 0.0)).xyz;
  let met = stretch(place, own, params.low, params.high);
  let end = max(min(met.y, most), met.x);
  let held = held_between(occluders, occluders_sampler, params.unit_per_cell, place, own, met.x, end);
  let depth = select(vec3f(0.0), held * (way_world / params.cell_world), met.x < end);
  return depth + rest_depth_along(p_cell, way, most, way_world);
}

// Optical depth of grey light along a way, of which one is as long as the world's unit, from a distance up to the radius.
fn depth_round(p_cell: vec3f, way: vec3f, begin_world: f32) -> f32 {
  let place = (params.from_cells * vec4f(p_cell + begin_world * way, 1.0)).xyz;
  let own = (params.from_cells * vec4f(params.step_world * way, 0.0)).xyz;
  var depth = 0.0;
  for (var k = 0u; k < params.steps; k++) { depth += depth_at(place + (f32(k) + 0.5) * own); }
  return depth * params.step_world / params.cell_world + rest_depth_round(p_cell, way, begin_world);
}

// Optical depth of a cell's length here; beyond the volume there is nothing.
fn depth_at(p_cell: vec3f) -> f32 {
  let inside = all(p_cell >= vec3f(0.0)) && all(p_cell <= params.last);
  return select(0.0, textureSampleLevel(occluders, occluders_sampler, p_cell * params.unit_per_cell, 0.0).r, inside);
}
