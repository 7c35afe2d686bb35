// Nothing is known to be empty.

import package::sample::Sample;

fn empty_slab(front: Sample, back: Sample) -> bool { return false; }
