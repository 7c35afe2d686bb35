// Which triangle of a mesh is the nearest at each pixel, by its number from 1 on, and of which mesh.

import generated::mesh::params;
import package::corner::Corner;
import package::raster::corner_of;
import slot::seen::is_cut;

@vertex
fn at_corner(@location(0) p_mesh: vec3f, @builtin(vertex_index) number: u32) -> Corner { return corner_of(p_mesh, number); }

@fragment
fn nearest(at: Corner) -> @location(0) vec2u {
  if (is_cut(at)) { discard; }
  return vec2u(at.triangle + 1u, params.number);
}
