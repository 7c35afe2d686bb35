// Trilinear interpolation with weights in full precision, four channels at a time.

import generated::field::grid;
import generated::layer::layer;
import generated::sizes::{Values, GROUPS};
import package::field::channels::{first_slice, weighted_sum};
import package::ray::INFINITE;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let p = clamp(place.p_index, vec3f(0.0), layer.size - 1.0);
  let low = floor(p);
  let w = p - low;
  let a = vec3i(low);
  let b = min(a + 1, vec3i(layer.size) - 1);
  var values: Values;
  for (var group = 0u; group < GROUPS; group++) {
    let first = i32(first_slice(group));
    let x00 = mix(voxel(a.x, a.y, a.z + first), voxel(b.x, a.y, a.z + first), w.x);
    let x10 = mix(voxel(a.x, b.y, a.z + first), voxel(b.x, b.y, a.z + first), w.x);
    let x01 = mix(voxel(a.x, a.y, b.z + first), voxel(b.x, a.y, b.z + first), w.x);
    let x11 = mix(voxel(a.x, b.y, b.z + first), voxel(b.x, b.y, b.z + first), w.x);
    values[group] = mix(mix(x00, x10, w.y), mix(x01, x11, w.y), w.z) * layer.channel_scale[group] + layer.channel_offset[group];
  }
  return values;
}

fn voxel(x: i32, y: i32, z: i32) -> vec4f { return textureLoad(grid, vec3i(x, y, z), 0); }

fn field_scalar(place: Place) -> f32 { return weighted_sum(field_value(place)); }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
