// Trilinear interpolation with weights in full precision.

import generated::linear_exact::grid;
import generated::layer::layer;
import package::field::cell::cell_derivative;
import package::ray::INFINITE;
import generated::sizes::Values;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let p = clamp(place.p_index, vec3f(0.0), layer.size - 1.0);
  let low = floor(p);
  let w = p - low;
  let a = vec3i(low);
  let b = min(a + 1, vec3i(layer.size) - 1);
  let x00 = mix(voxel(a.x, a.y, a.z), voxel(b.x, a.y, a.z), w.x);
  let x10 = mix(voxel(a.x, b.y, a.z), voxel(b.x, b.y, a.z), w.x);
  let x01 = mix(voxel(a.x, a.y, b.z), voxel(b.x, a.y, b.z), w.x);
  let x11 = mix(voxel(a.x, b.y, b.z), voxel(b.x, b.y, b.z), w.x);
  return mix(mix(x00, x10, w.y), mix(x01, x11, w.y), w.z) * layer.value_scale + layer.value_offset;
}

fn voxel(x: i32, y: i32, z: i32) -> f32 { return textureLoad(grid, vec3i(x, y, z), 0).r; }

fn field_derivative(place: Place) -> vec3f { return cell_derivative(place.p_index) * layer.value_scale; }

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
