// What was found at surfaces is drawn and forgotten.

const KEEPS_HITS = false;

fn keep_hit(pixel: u32, shape: vec4f, place: vec4f) {}
