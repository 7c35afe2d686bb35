// Which triangle is the nearest at each pixel of those behind the ones that were found before, and in front of what is opaque
// (Everitt 2001). Depths fall from 1 at the eye to 0.

import generated::mesh::params;
import generated::pass::{peeled_depth, opaque_depth};
import package::raster::{Corner, corner_of};
import slot::seen::is_cut;

@vertex
fn at_corner(@location(0) p_mesh: vec3f, @builtin(vertex_index) number: u32) -> Corner { return corner_of(p_mesh, number); }

@fragment
fn nearest(at: Corner) -> @location(0) vec2u {
  let pixel = vec2i(at.place.xy);
  let depth = at.place.z;
  if (depth >= textureLoad(peeled_depth, pixel, 0) || depth <= textureLoad(opaque_depth, pixel, 0) || is_cut(at)) { discard; }
  return vec2u(at.triangle + 1u, params.number);
}
