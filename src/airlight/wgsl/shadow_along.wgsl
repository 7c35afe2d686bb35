// What comes through to a place along its own ray to the light.

import generated::shadow::params as shadow;
import next::hides::depth_along;
import package::shadow_cells::to_light;
import package::ways::FAR;

fn through_along_ray(p_cell: vec3f) -> vec3f {
  let way = to_light(p_cell);
  return exp(-depth_along(p_cell, way, select(FAR, 1.0, shadow.light.w > 0.0), length(shadow.world_from_cells * way)));
}
