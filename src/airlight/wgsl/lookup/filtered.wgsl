// Tables interpolated by the texture unit.

fn table_at(table: texture_3d<f32>, table_sampler: sampler, place_unit: vec3f) -> vec4f {
  return textureSampleLevel(table, table_sampler, place_unit, 0.0);
}

fn layer_at(table: texture_2d_array<f32>, table_sampler: sampler, place_unit: vec2f, layer: u32) -> vec4f {
  return textureSampleLevel(table, table_sampler, place_unit, layer, 0.0);
}
