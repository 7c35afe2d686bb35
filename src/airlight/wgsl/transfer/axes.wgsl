// The axes of several functions, by number: four to a column of the parameters.

import generated::transfer::{params, function, STEPPED_ENDS};
import package::transfer::cells::Axis;

fn axis_of(number: u32) -> Axis {
  let group = number / 4u;
  let lane = number % 4u;
  var axis: Axis;
  axis.layer = number;
  axis.first_value = params.first_value[group][lane];
  axis.last_value = params.last_value[group][lane];
  axis.per_value = params.per_value[group][lane];
  axis.even_cells = u32(params.even_cells[group][lane]);
  if (STEPPED_ENDS) {
    let line = textureDimensions(function).y - 1u;
    axis.first_medium = textureLoad(function, vec3u(0u, line, number), 0);
    axis.last_medium = textureLoad(function, vec3u(1u, line, number), 0);
  }
  return axis;
}
