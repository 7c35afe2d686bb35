// A piece of a ray that is drawn.

struct Kept {
  begin: f32,  // [world]
  end: f32,
  near: u32,   // number of the clip at whose surface it begins, counted from 1; 0 where none does
  far: u32,
}
