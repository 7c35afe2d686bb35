// No clip cuts a mesh.

import package::raster::Corner;

fn is_cut(at: Corner) -> bool { return false; }
