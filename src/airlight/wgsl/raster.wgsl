// Corners of triangles on the part of the image that is drawn. What clips cut away of them: `slot::seen`.

import generated::mesh::params;
import package::corner::Corner;
import package::on_tile::on_tile;

// The first corner of each triangle is a vertex of its own, which has the triangle's number.
fn corner_of(p_mesh: vec3f, number: u32) -> Corner {
  let p_world = (params.world_from_mesh * vec4f(p_mesh, 1.0)).xyz;
  return Corner(on_tile(p_world, params.near_world, params.far_world), number);
}
