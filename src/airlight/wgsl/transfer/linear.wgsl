// A stretch along which colour and extinction are linear: what it sends to its ends.

// Gauss' rule with eight nodes on [0, 1]: the lower half, the others are 1 - x.
const NODES = vec4f(0.0198550718, 0.1016667613, 0.2372337950, 0.4082826788);
const WEIGHTS = vec4f(0.0506142681, 0.1111905172, 0.1568533229, 0.1813418917);

// Attenuated sums over a linear part: white light; and towards either end that of the source times 1, x and x^2, and of white
// light times x, with x the share of the part's width from this end.
struct Sums { white: f32, to_low: vec4f, to_high: vec4f }

fn sums_over(extinction_low: f32, rise: f32, length: f32, through: f32, associated: bool) -> Sums {
  let a = sums_at(NODES, extinction_low, rise, length, through, associated);
  let b = sums_at(1.0 - NODES, extinction_low, rise, length, through, associated);
  return Sums(a.white + b.white, a.to_low + b.to_low, a.to_high + b.to_high);
}

fn sums_at(x: vec4f, extinction_low: f32, rise: f32, length: f32, through: f32, associated: bool) -> Sums {
  let extinction = extinction_low + x * rise;
  let seen_low = exp(-length * x * (extinction_low + 0.5 * x * rise));
  let seen_high = through / max(seen_low, vec4f(1e-37));
  let weight = length * WEIGHTS;
  let white = weight * extinction;
  let source = select(white, weight, associated);
  return Sums(
    dot(white, seen_low),
    sums_of(x, source * seen_low, white * seen_low),
    sums_of(1.0 - x, source * seen_high, white * seen_high),
  );
}

fn sums_of(x: vec4f, source: vec4f, white: vec4f) -> vec4f {
  return vec4f(dot(source, vec4f(1.0)), dot(source, x), dot(source, x * x), dot(white, x));
}
