// Tables interpolated by the texture unit.

fn table_at(table: texture_3d<f32>, table_sampler: sampler, place_unit: vec3f) -> vec4f {
  return textureSampleLevel(table, table_sampler, place_unit, 0.0);
}
