// Cubic B-spline by eight fetches: the texture unit adds each two neighbours, weighted, when it is asked at the right place
// between them (Sigg and Hadwiger, GPU Gems 2, chapter 20).

import generated::layer::layer;
import generated::sizes::Values;
import package::ray::INFINITE;
import slot::voxels::sample_at;

struct Place { p_index: vec3f }

fn locate(p_index: vec3f) -> Place { return Place(p_index); }

fn field_value(place: Place) -> Values {
  let pair = pairs(place.p_index);
  return weighted(pair) * layer.value_scale + layer.value_offset;
}

fn field_derivative(place: Place) -> vec3f {
  let pair = pairs(place.p_index);
  let slope = slope_pairs(place.p_index);
  var sum = vec3f(0.0);
  for (var axis = 0u; axis < 3u; axis++) {
    let along = vec3u(axis) == vec3u(0u, 1u, 2u);
    sum[axis] = weighted(Pairs(
      select(pair.low, slope.low, along), select(pair.high, slope.high, along),
      select(pair.low_weight, slope.low_weight, along), select(pair.high_weight, slope.high_weight, along),
    ));
  }
  return sum * layer.value_scale;
}

// Where the two lower and the two upper neighbours along each axis are fetched at once [voxel], and what they weigh together.
struct Pairs { low: vec3f, high: vec3f, low_weight: vec3f, high_weight: vec3f }

fn pairs(p_index: vec3f) -> Pairs {
  let cell = floor(p_index);
  let f = p_index - cell;
  let g = 1.0 - f;
  let second = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0;
  let fourth = f * f * f / 6.0;
  let low_weight = g * g * g / 6.0 + second;
  return Pairs(cell - 1.0 + second / low_weight, cell + 1.0 + fourth / (1.0 - low_weight), low_weight, 1.0 - low_weight);
}

// The same for the derivative: both lower weights are negative, both upper ones positive.
fn slope_pairs(p_index: vec3f) -> Pairs {
  let cell = floor(p_index);
  let f = p_index - cell;
  let low_weight = f * f - f - 0.5;
  let second = 0.5 * f * (3.0 * f - 4.0);
  let fourth = 0.5 * f * f;
  return Pairs(cell - 1.0 + second / low_weight, cell + 1.0 - fourth / low_weight, low_weight, -low_weight);
}

fn weighted(pair: Pairs) -> f32 {
  let low = pair.low;
  let high = pair.high;
  let x = vec2f(pair.low_weight.x, pair.high_weight.x);
  let near = pair.low_weight.y * dot(x, two(low.x, high.x, low.y, low.z)) + pair.high_weight.y * dot(x, two(low.x, high.x, high.y, low.z));
  let far = pair.low_weight.y * dot(x, two(low.x, high.x, low.y, high.z)) + pair.high_weight.y * dot(x, two(low.x, high.x, high.y, high.z));
  return pair.low_weight.z * near + pair.high_weight.z * far;
}

fn two(low_x: f32, high_x: f32, y: f32, z: f32) -> vec2f {
  return vec2f(sample_at(vec3f(low_x, y, z)).r, sample_at(vec3f(high_x, y, z)).r);
}

fn extent(place: Place, direction: vec3f) -> f32 { return INFINITE; }
