// All triangles at each pixel in front of what is opaque, in one pass.

import package::corner::Corner;
import package::gathering::gather;
import package::raster::corner_of;

@vertex
fn at_corner(@location(0) p_mesh: vec3f, @builtin(vertex_index) number: u32) -> Corner { return corner_of(p_mesh, number); }

@fragment
fn nearest(at: Corner, @builtin(front_facing) is_front: bool) { gather(at, at.place.z, is_front); }
