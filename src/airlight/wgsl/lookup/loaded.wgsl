// Tables interpolated in the shader, for devices that do not filter 32-bit floats.

fn table_at(table: texture_3d<f32>, table_sampler: sampler, place_unit: vec3f) -> vec4f {
  let size = vec3f(textureDimensions(table));
  let p = clamp(place_unit * size - 0.5, vec3f(0.0), size - 1.0);
  let low = floor(p);
  let w = p - low;
  var sum = vec4f(0.0);
  for (var corner = 0u; corner < 8u; corner++) {
    let high = vec3f(vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u));
    let share = mix(1.0 - w, w, high);
    sum += textureLoad(table, vec3i(min(low + high, size - 1.0)), 0) * (share.x * share.y * share.z);
  }
  return sum;
}

fn layer_at(table: texture_2d_array<f32>, table_sampler: sampler, place_unit: vec2f, layer: u32) -> vec4f {
  let size = vec2f(textureDimensions(table));
  let p = clamp(place_unit * size - 0.5, vec2f(0.0), size - 1.0);
  let low = vec2u(p);
  let high = min(low + 1u, vec2u(size) - 1u);
  let w = fract(p);
  let a = mix(textureLoad(table, low, layer, 0), textureLoad(table, vec2u(high.x, low.y), layer, 0), w.x);
  let b = mix(textureLoad(table, vec2u(low.x, high.y), layer, 0), textureLoad(table, high, layer, 0), w.x);
  return mix(a, b, w.y);
}
