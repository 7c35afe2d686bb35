// A corner of what a rasteriser draws of a triangle.

struct Corner { @builtin(position) place: vec4f, @location(0) @interpolate(flat) triangle: u32 }
