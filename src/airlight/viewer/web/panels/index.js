// The panels, in any order; each tells its own place.
export const panels = [];
