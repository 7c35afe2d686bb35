// What was found at surfaces is drawn and forgotten.

import package::met::Met;
import package::sample::Result;
import package::walk::Line;

fn keep_hit(pixel: u32, line: Line, shown: Result, met: Met) {}
