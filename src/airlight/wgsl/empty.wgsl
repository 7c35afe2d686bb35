// Samples that hold nothing: NaN and no-data. They are marked by a value that no data has.

const EMPTY: f32 = -3.0e38;

fn is_empty(value: f32) -> bool { return value <= EMPTY; }
