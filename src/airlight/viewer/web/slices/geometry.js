// Where slices lie: planes by name, steps of a voxel, places in their pixels and points of the world.
import { cross, dot, minus, plus, times, unit } from "../vectors.js";
import { basis } from "../view.js";

const WAYS = {
  // right and up in the world: patient LPS, seen as radiologists do
  axial: { right: [1, 0, 0], up: [0, -1, 0] },
  coronal: { right: [1, 0, 0], up: [0, 0, 1] },
  sagittal: { right: [0, 1, 0], up: [0, 0, 1] },
};

/** Right and up of a plane by its name; the oblique one faces the eye, or has a normal of its own. */
export function waysOf(name, camera, normal) {
  if (WAYS[name]) return WAYS[name];
  const seen = basis(camera);
  if (!normal) return { right: seen.right, up: seen.up };
  const toEye = unit(normal);
  // Up stays as near to the view's as it can.
  const right = cross(Math.abs(dot(seen.up, toEye)) > 0.99 ? seen.forward : seen.up, toEye);
  return { right: unit(right), up: unit(cross(toEye, unit(right))) };
}

/** World length of a step along a direction that passes one voxel. */
export function voxelStep(indexFromWorld, direction) {
  const most = Math.max(...indexFromWorld.map((row) => Math.abs(dot(row, direction))));
  return most > 0 ? 1 / most : 1;
}

/** Rows of the linear part of the inverse of an affine matrix. */
export function inverseRows(matrix) {
  const [a, b, c] = [0, 1, 2].map((column) => [0, 1, 2].map((row) => matrix[row][column]));
  const volume = dot(a, cross(b, c));
  return [cross(b, c), cross(c, a), cross(a, b)].map((row) => times(row, 1 / volume));
}

/** Extent of corners along a direction: [low, high]. */
export const along = (corners, direction) =>
  corners.reduce(([a, b], p) => [Math.min(a, dot(p, direction)), Math.max(b, dot(p, direction))], [Infinity, -Infinity]);

/** Point of the world at a place of a slice in its pixels, and back. */
export const worldAt = ({ centre, right, up, pixel }, [width, height], [x, y]) =>
  plus(plus(centre, right, (x - width / 2) * pixel), up, (height / 2 - y) * pixel);
export const placeOf = ({ centre, right, up, pixel }, [width, height], p) => {
  const away = minus(p, centre);
  return [width / 2 + dot(away, right) / pixel, height / 2 - dot(away, up) / pixel];
};
