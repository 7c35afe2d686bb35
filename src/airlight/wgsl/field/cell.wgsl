// The derivative of trilinear interpolation within the cell of a place, or the cell below it on the upper faces of the grid.

import generated::field::grid;
import generated::layer::layer;

// [texel/voxel]
fn cell_derivative(p_index: vec3f) -> vec3f {
  let last = layer.size - 1.0;
  let p = clamp(p_index, vec3f(0.0), last);
  let low = min(floor(p), max(last - 1.0, vec3f(0.0)));
  let w = p - low;
  let a = vec3i(low);
  let b = vec3i(min(low + 1.0, last));
  // Slopes along x on four edges, and the values of four points from which those along y and z follow.
  let low_x = vec4f(texel(a.x, a.y, a.z), texel(a.x, b.y, a.z), texel(a.x, a.y, b.z), texel(a.x, b.y, b.z));
  let high_x = vec4f(texel(b.x, a.y, a.z), texel(b.x, b.y, a.z), texel(b.x, a.y, b.z), texel(b.x, b.y, b.z));
  let slope = high_x - low_x;
  let value = mix(low_x, high_x, w.x);
  return vec3f(
    mix(mix(slope.x, slope.y, w.y), mix(slope.z, slope.w, w.y), w.z),
    mix(value.y - value.x, value.w - value.z, w.z),
    mix(value.z - value.x, value.w - value.y, w.y),
  );
}

fn texel(x: i32, y: i32, z: i32) -> f32 { return textureLoad(grid, vec3i(x, y, z), 0).r; }
