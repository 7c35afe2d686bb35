// Vectors as lists of three numbers.
export const minus = (a, b) => a.map((x, n) => x - b[n]);
export const plus = (a, b, factor = 1) => a.map((x, n) => x + factor * b[n]);
export const times = (a, factor) => a.map((x) => x * factor);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(...a);
export const unit = (a) => times(a, 1 / (length(a) || 1));

/** A point under an affine matrix of four rows (or three). */
export const placed = (matrix, p) => [0, 1, 2].map((row) => dot(matrix[row], p) + matrix[row][3]);

/** How far along a line (point, unit direction) it is nearest to a ray { origin, direction }; null where both are parallel. */
export function nearestAlong(point, direction, ray) {
  const across = dot(direction, ray.direction);
  const below = 1 - across * across;
  if (below < 1e-6) return null;
  const between = minus(ray.origin, point);
  return (dot(between, direction) - dot(between, ray.direction) * across) / below;
}

/** Where a ray is nearest to the centre of a sphere, put onto the sphere; the near side where it meets it. */
export function onSphere(centre, radius, ray) {
  const along = dot(minus(centre, ray.origin), ray.direction);
  const aside = minus(plus(ray.origin, ray.direction, along), centre);
  const distance = length(aside);
  if (distance >= radius) return plus(centre, unit(aside), radius);
  return plus(plus(centre, aside), ray.direction, -Math.sqrt(radius * radius - distance * distance));
}
