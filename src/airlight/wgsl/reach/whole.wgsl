// Nothing is known of where rays meet the first block that holds something, and the last.

import package::walk::Line;

fn bounded(line: Line, pixel: vec2u) -> Line { return line; }
