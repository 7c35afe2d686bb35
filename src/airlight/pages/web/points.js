// What an editor does to control points, [[value, [r, g, b], extinction], ...] by rising value. Nothing is changed in place.

import { mediumAt } from "./function.js";
import { extinctionAt, heightOf } from "./scales.js";

const LEAST = 2;

const clamped = (x, low, high) => Math.min(Math.max(x, low), high);
const replaced = (points, index, point) => points.map((old, n) => (n === index ? point : old));

/** Move a point, between its neighbours and above zero. */
export function moved(points, index, value, extinction) {
  const low = points[index - 1]?.[0] ?? -Infinity;
  const high = points[index + 1]?.[0] ?? Infinity;
  return replaced(points, index, [clamped(value, low, high), points[index][1], Math.max(extinction, 0)]);
}

/** Put in a point that changes nothing yet: { points, index }. Beyond the ends it goes on as they do. */
export function added(points, value) {
  const [r, g, b, extinction] = mediumAt(points, value);
  const index = points.filter((p) => p[0] <= value).length;
  return { points: [...points.slice(0, index), [value, [r, g, b], extinction], ...points.slice(index)], index };
}

/** Value in the middle of the wider gap beside a point. */
export function besides(points, index) {
  if (points.length === 1) return points[0][0];
  const gaps = [index - 1, index].filter((n) => n >= 0 && n + 1 < points.length);
  const width = (n) => points[n + 1][0] - points[n][0];
  const widest = gaps.reduce((best, n) => (width(n) > width(best) ? n : best), gaps[0]);
  return (points[widest][0] + points[widest + 1][0]) / 2;
}

/** Take a point out, unless only two are left. */
export function removed(points, index) {
  return points.length > LEAST ? points.filter((_, n) => n !== index) : points;
}

export const recoloured = (points, index, rgb) => replaced(points, index, [points[index][0], rgb, points[index][2]]);

const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Move a point by a key: a hundredth of the axes, a tenth of that for fine steps; null for other keys. */
export function nudged(points, index, key, [low, high], top, fine) {
  if (!(key in KEYS)) return null;
  const [dx, dy] = KEYS[key].map((way) => way * (fine ? 0.001 : 0.01));
  const [value, , extinction] = points[index];
  const raised = dy === 0 ? extinction : extinctionAt(heightOf(extinction, top) + dy, top);
  return moved(points, index, value + dx * (high - low), raised);
}
