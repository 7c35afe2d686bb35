// Octahedral maps: all directions on a square without a seam (Engelhardt and Dachsbacher 2008).

// Place of a direction in a map of n x n texels whose outermost texels lie on the edge of the square.
fn octahedral_place(direction: vec3f, n: f32) -> vec2f {
  let p = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-9);
  let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p.xy >= vec2f(0.0));
  let place = select(folded, p.xy, p.z >= 0.0);
  return ((0.5 + 0.5 * place) * (n - 1.0) + 0.5) / n;
}
