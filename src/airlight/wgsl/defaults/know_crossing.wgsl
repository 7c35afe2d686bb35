// The medium is the same on both sides of a surface.

import package::sample::{Sample, Sheet};
import slot::transfer::{Known, know};

fn know_crossing(sheet: Sheet, hit: Sample, behind: bool) -> Known { return know(hit); }
