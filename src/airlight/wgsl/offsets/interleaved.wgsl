// Sixteen shifts over squares of 4 x 4 pixels (Scharsach, section 5).

fn offset_of(pixel: vec2u) -> f32 {
  let fine = pixel & vec2u(1u);
  let coarse = (pixel >> vec2u(1u)) & vec2u(1u);
  let rank = 4u * (2u * (fine.x ^ fine.y) + fine.y) + 2u * (coarse.x ^ coarse.y) + coarse.y;
  return f32(rank) / 16.0;
}
