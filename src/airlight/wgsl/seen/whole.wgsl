// No clip cuts a mesh.

import package::corner::Corner;

fn is_cut(at: Corner) -> bool { return false; }
