// Control points as plain data, [value, [r, g, b], extinction]: what edits make of them. Nothing is changed in place.

const between = (a, b, share) => a * (1 - share) + b * share;

/** Colour and extinction at a value, as the library has them: straight between points, the later one at a step. */
export function evaluate(points, value) {
  let n = points.length;
  while (n > 0 && points[n - 1][0] > value) n -= 1;
  const lower = points[Math.max(0, n - 1)];
  const upper = points[Math.min(n, points.length - 1)];
  const width = upper[0] - lower[0];
  const share = width > 0 ? (value - lower[0]) / width : 0;
  return { rgb: lower[1].map((c, k) => between(c, upper[1][k], share)), extinction: between(lower[2], upper[2], share) };
}

/** Values between which a point may lie. */
export const room = (points, n) => [points[n - 1]?.[0] ?? -Infinity, points[n + 1]?.[0] ?? Infinity];

/** A point moved, no further than its neighbours: two at one value are a step. */
export function moved(points, n, value, extinction) {
  const [low, high] = room(points, n);
  return points.with(n, [Math.min(high, Math.max(low, value)), points[n][1], Math.max(0, extinction)]);
}

/** A point added on the curve: [points, its number]. */
export function added(points, value) {
  const { rgb, extinction } = evaluate(points, value);
  const n = points.findLastIndex((point) => point[0] <= value) + 1;
  return [points.toSpliced(n, 0, [value, rgb, extinction]), n];
}

/** A point removed; the last one stays. */
export const removed = (points, n) => (points.length > 1 ? points.toSpliced(n, 1) : points);

/** A point in another colour. */
export const recoloured = (points, n, rgb) => points.with(n, [points[n][0], rgb, points[n][2]]);

/** First and last value. */
export const domain = (points) => [points[0][0], points.at(-1)[0]];

/** A function, { points, surfaces }, moved and stretched as a whole to another centre and width. */
export function windowed(transfer, centre, width) {
  const [low, high] = domain(transfer.points);
  const was = high - low;
  const middle = low + was / 2;
  const stretch = was > 0 ? Math.max(width, 1e-9 * was) / was : 1;
  const place = (value) => centre + (value - middle) * stretch;
  const points = transfer.points.map(([value, ...rest]) => [place(value), ...rest]);
  const surfaces = transfer.surfaces?.map((surface) => ({ ...surface, value: place(surface.value) }));
  return { ...transfer, points, ...(surfaces ? { surfaces } : {}) };
}

/** The colour at the greatest extinction, at full light. */
export function mainColour(points) {
  const most = points.reduce((best, point) =>
    point[2] > best[2] || (point[2] === best[2] && lightOf(point[1]) > lightOf(best[1])) ? point : best,
  );
  const light = lightOf(most[1]) || 1;
  return most[1].map((c) => Math.min(1, c / light));
}

/** All points in one colour, each as bright as it was. */
export const tinted = (points, rgb) =>
  points.map(([value, old, extinction]) => [value, rgb.map((c) => c * lightOf(old)), extinction]);

const lightOf = (rgb) => Math.max(...rgb);
