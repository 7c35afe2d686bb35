// What makers and readers of tables of slabs agree on.

// Shifts are kept as multiples of how far attenuation moves light, but not of less than this: thin slabs have none to speak of.
const LEAST_MOVE: f32 = 1e-3;
