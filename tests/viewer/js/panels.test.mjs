// Pure functions of panels and overlays.
import assert from "node:assert/strict";
import test from "node:test";

import { hexOf, linearOf, patient, rounded } from "../../../src/airlight/viewer/web/controls.js";
import { directionOf, onBall, placeOf } from "../../../src/airlight/viewer/web/panels/lights.js";
import { cross, dot, length, minus, nearestAlong, onSphere, plus, times, unit } from "../../../src/airlight/viewer/web/vectors.js";
import { basis, projected, unprojected } from "../../../src/airlight/viewer/web/view.js";

// A small generator of numbers that are always the same.
let seed = 7;
const random = (low = -1, high = 1) => low + ((high - low) * (seed = (seed * 48271) % 2147483647)) / 2147483647;
const point = (size = 1) => [random(-size, size), random(-size, size), random(-size, size)];
const close = (a, b, by = 1e-9) => a.forEach((x, n) => assert.ok(Math.abs(x - b[n]) <= by, `${a} is not ${b}`));
const camera = () => ({ name: random() > 0 ? "perspective" : "orthographic", eye: point(10), target: point(2), up: unit(point()), fov_deg: random(10, 80), height: random(1, 9) });

test("colours come back", () => {
  for (const hex of ["#000000", "#ffffff", "#6ab0ff", "#010203", "#0b0a0c"]) assert.equal(hexOf(linearOf(hex)), hex);
});

test("places on the ball come back", () => {
  for (let n = 0; n < 200; n++) {
    const seen = camera();
    const place = [random(-0.7, 0.7), random(-0.7, 0.7)];
    const direction = directionOf(place, seen);
    assert.ok(Math.abs(length(direction) - 1) < 1e-9);
    close(placeOf(times(direction, random(0.1, 5)), seen), place, 1e-6);
  }
});

test("the middle of the ball is the eye, its rim behind", () => {
  const seen = { eye: [0, -4, 0], target: [0, 0, 0], up: [0, 0, 1] };
  close(directionOf([0, 0], seen), [0, -1, 0]);
  close(directionOf([0.5, 0], seen), [1, 0, 0]);
  close(directionOf([0, 0.5], seen), [0, 0, 1]);
  close(directionOf([1, 0], seen), [0, 1, 0]);
});

test("a light that is dragged beyond the rim stays where it is seen", () => {
  const seen = camera();
  const place = placeOf(directionOf(onBall([3, -1]), seen), seen);
  assert.ok(place[0] > 0.9 && place[1] < -0.3 && Math.hypot(...place) < 1, `${place}`);
  close(onBall([0.2, 0.3]), [0.2, 0.3]);
  close(onBall([0, 0]), [0, 0]);
});

test("what comes while a user is at a control is shown afterwards, the last alone", async () => {
  const shown = [];
  let busy = true;
  const control = patient((value) => shown.push(value), () => busy);
  control.show(1);
  control.show(2);
  busy = false;
  assert.deepEqual(shown, []);
  await new Promise((done) => setTimeout(done, 300));
  assert.deepEqual(shown, [2]);
  control.said();
  control.show(3); // late: what was said before the last input
  control.show(4);
  assert.deepEqual(shown, [2]);
  await new Promise((done) => setTimeout(done, 300));
  assert.deepEqual(shown, [2, 4]);
  control.show(5);
  assert.deepEqual(shown, [2, 4, 5]);
});

test("numbers are rounded behind the point, never before it", () => {
  assert.deepEqual([0, 0.461352, -123456.789, 12.345678, 1e-7].map(rounded), [0, 0.46135, -123456.79, 12.346, 1e-7]);
});

test("a ray of a point of the view meets what is shown there", () => {
  for (let n = 0; n < 200; n++) {
    const [seen, size] = [camera(), [640, 480]];
    const [x, y] = [random(0, 640), random(0, 480)];
    const { origin, direction } = unprojected(seen, x, y, size);
    close(projected(seen, plus(origin, direction, random(0.5, 20)), size), [x, y], 1e-5);
  }
});

test("nothing behind the eye is in the view", () => {
  const seen = { name: "perspective", eye: [0, 0, 0], target: [0, 1, 0], up: [0, 0, 1], fov_deg: 30 };
  assert.equal(projected(seen, [0, -1, 0], [100, 100]), null);
});

test("axes of a camera are a right-handed frame", () => {
  const { right, up, forward } = basis(camera());
  close(cross(right, up), times(forward, -1));
});

test("the nearest point of a line to a ray that meets it is where both meet", () => {
  for (let n = 0; n < 200; n++) {
    const [start, along, t] = [point(), unit(point()), random(-5, 5)];
    const meeting = plus(start, along, t);
    const origin = plus(meeting, point(), 3);
    assert.ok(Math.abs(nearestAlong(start, along, { origin, direction: unit(minus(meeting, origin)) }) - t) < 1e-5);
  }
  assert.equal(nearestAlong([0, 0, 0], [1, 0, 0], { origin: [0, 1, 0], direction: [1, 0, 0] }), null);
});

test("points on spheres lie on them, and on the ray where it meets", () => {
  for (let n = 0; n < 100; n++) {
    const [centre, radius] = [point(), random(0.5, 2)];
    const ray = { origin: plus(centre, unit(point()), 9), direction: unit(point()) };
    const found = onSphere(centre, radius, ray);
    assert.ok(Math.abs(length(minus(found, centre)) - radius) < 1e-6);
    const towards = { ...ray, direction: unit(minus(centre, ray.origin)) };
    const hit = onSphere(centre, radius, towards);
    assert.ok(Math.abs(dot(minus(hit, ray.origin), towards.direction) - (9 - radius)) < 1e-6);
  }
});
