// Pure functions of the exported page.
import assert from "node:assert/strict";
import test from "node:test";

import { basis, dolly, dot, orbit, pan, roomFor, shownHeight, within } from "../../../src/airlight/pages/web/camera.js";
import { entriesFor } from "../../../src/airlight/pages/web/function.js";
import { gestureOfKey, gesturesOfFingers } from "../../../src/airlight/pages/web/gestures.js";
import { added, besides, moved, nudged, recoloured, removed } from "../../../src/airlight/pages/web/points.js";
import { extinctionAt, heightOf, hexOf, inWords, rgbOf, ticks } from "../../../src/airlight/pages/web/scales.js";
import { halfOf, histogram } from "../../../src/airlight/pages/web/volume.js";

const close = (a, b, by = 1e-9) => a.forEach((x, n) => assert.ok(Math.abs(x - b[n]) <= by, `${a} is not ${b}`));
const camera = { name: "perspective", eye: [3, -4, 2], target: [1, 1, 1], up: [0, 0, 1], fov_deg: 30 };
const distance = ({ eye, target }) => Math.hypot(...eye.map((x, n) => x - target[n]));
const points = [[0, [0, 0, 0], 0], [10, [1, 0, 0], 2], [30, [1, 1, 1], 2]];

test("a turn keeps the distance and the height of the eye, and undone it is none", () => {
  const turned = orbit(camera, 0.3, 0);
  close([distance(turned), turned.eye[2]], [distance(camera), camera.eye[2]]);
  close(orbit(turned, -0.3, 0).eye, camera.eye);
});

test("half a height is a quarter turn, to the right: the eye goes to the left", () => {
  const turned = orbit({ ...camera, eye: [0, -5, 0], target: [0, 0, 0] }, 0.5, 0);
  close(turned.eye, [-5, 0, 0]);
});

test("a turn stops short of the poles", () => {
  const { forward } = basis(orbit(camera, 0, 9));
  assert.ok(Math.abs(forward[2]) < 0.999);
});

test("what is dragged stays under the pointer", () => {
  const after = pan(camera, 0.25, 0);
  const { right } = basis(camera);
  close([dot(right, after.eye.map((x, n) => x - camera.eye[n]))], [-0.25 * shownHeight(camera)]);
});

test("nearer and farther, within bounds", () => {
  assert.ok(distance(dolly(camera, 0, -0.1)) < distance(camera));
  assert.ok(dolly({ name: "orthographic", eye: [0, -1, 0], target: [0, 0, 0], up: [0, 0, 1], height: 2 }, 0, 0.1).height > 2);
  let far = camera;
  for (let n = 0; n < 99; n++) far = within(dolly(far, 0, 1), camera);
  close([distance(far) / distance(camera)], [1000], 1e-6);
});

test("a narrow view shows what the still picture does", () => {
  assert.equal(roomFor([400, 800], [512, 512]), 2);
  assert.equal(roomFor([800, 400], [512, 512]), 1);
});

test("keys and fingers", () => {
  assert.deepEqual(gestureOfKey({ key: "ArrowLeft", shiftKey: false }), { kind: "orbit", dx: -0.04, dy: 0 });
  assert.equal(gestureOfKey({ key: "ArrowUp", shiftKey: true }).kind, "pan");
  assert.equal(gestureOfKey({ key: "a" }), null);
  const [move, pinch] = gesturesOfFingers([[0, 0], [10, 0]], [[0, 0], [20, 0]], 100);
  close([move.dx, pinch.dy], [0.05, Math.log(0.5) / 2]);
  assert.equal(gesturesOfFingers([[0, 0]], [[10, 0]], 100)[0].kind, "orbit");
});

test("a point stays between its neighbours, and extinction above zero", () => {
  assert.deepEqual(moved(points, 1, 99, -1)[1], [30, [1, 0, 0], 0]);
  assert.deepEqual(moved(points, 1, -99, 1)[1].slice(0, 1), [0]);
  assert.deepEqual(points[1], [10, [1, 0, 0], 2]);
});

test("a point that is put in changes nothing, and one that is taken out is gone", () => {
  const { points: more, index } = added(points, 5);
  assert.deepEqual(more[index], [5, [0.5, 0, 0], 1]);
  assert.deepEqual(removed(more, index), points);
  assert.equal(removed(points.slice(0, 2), 0).length, 2);
  assert.equal(added(points, 50).index, 3);
  assert.equal(besides(points, 1), 20);
  assert.equal(besides([[7, [1, 1, 1], 1]], 0), 7);
});

test("keys move points", () => {
  close([nudged(points, 1, "ArrowRight", [0, 100], 4, false)[1][0]], [11]);
  const [, , raised] = nudged(points, 1, "ArrowUp", [0, 100], 4, true)[1];
  close([heightOf(raised, 4) - heightOf(2, 4)], [0.001]);
  assert.equal(nudged(points, 1, "x", [0, 100], 4, false), null);
});

test("axes and colours come back", () => {
  for (const x of [0, 0.001, 1, 4]) close([extinctionAt(heightOf(x, 4), 4)], [x]);
  for (const hex of ["#000000", "#ffffff", "#6ab0ff", "#010203"]) assert.equal(hexOf(rgbOf(hex)), hex);
  assert.deepEqual(recoloured(points, 0, [1, 1, 1])[0][1], [1, 1, 1]);
  assert.deepEqual(ticks(-3, 12, 4), [0, 5, 10]);
  assert.equal(inWords(0.1 + 0.2), "0.3");
});

test("tables have room for narrow segments", () => {
  assert.equal(entriesFor({ points }, 128), 128);
  assert.equal(entriesFor({ points: [[0, [1, 1, 1], 0], [1, [1, 1, 1], 1], [100, [1, 1, 1], 1]] }, 128), 512);
  assert.equal(entriesFor({ points: [[0, [1, 1, 1], 0], [0, [1, 1, 1], 1]] }, 256), 256);
});

test("half floats and histograms", () => {
  assert.deepEqual([0x3c00, 0xc000, 0x0001, 0x7bff].map(halfOf), [1, -2, 2 ** -24, 65504]);
  const counts = histogram(new Uint8Array([0, 0, 255, 128]), { bits: 8, scale: 255, offset: 0 }, [0, 255], 2);
  assert.deepEqual([...counts], [2, 2]);
  const constant = histogram(new Uint8Array([0, 0, 0]), { bits: 8, scale: 1, offset: 7 }, [7, 7], 4);
  assert.deepEqual([...constant], [3, 0, 0, 0]);
});
