// The surface at which a ray ends; how it is found: `slot::met`.

// The value there; the side, 1 on the way up, 2 on the way down, 3 where what clips keep begins inside; the number of the clip that
// cuts there, 0 where none does; and that of the layer.
struct Met { value: f32, side: f32, clip: u32, layer: u32 }
