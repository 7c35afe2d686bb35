// Geometry of joint functions, of slices and of probing, without a page.
import assert from "node:assert/strict";
import test from "node:test";

import { agrees } from "../../../src/airlight/viewer/web/joint/function.js";
import { written } from "../../../src/airlight/viewer/web/joint/plot.js";
import {
  bounds,
  core,
  fitted,
  fresh,
  handles,
  hit,
  holds,
  outline,
  pulled,
  reordered,
  shifted,
  thirdOf,
  withCorner,
  withThird,
  withVariables,
  withoutCorner,
} from "../../../src/airlight/viewer/web/joint/shapes.js";
import { placeText } from "../../../src/airlight/viewer/web/seen.js";
import { usualWindow } from "../../../src/airlight/viewer/web/slices.js";
import { corner, replacedClips } from "../../../src/airlight/viewer/web/slices/cut.js";
import { inverseRows, placeOf, voxelStep, waysOf, worldAt } from "../../../src/airlight/viewer/web/slices/geometry.js";
import { cross, dot, length, times, unit } from "../../../src/airlight/viewer/web/vectors.js";

let seed = 5;
const random = (low = 0, high = 1) => low + ((high - low) * (seed = (seed * 48271) % 2147483647)) / 2147483647;
const close = (a, b, by = 1e-9) =>
  a.forEach((x, n) => assert.ok(Math.abs(x - b[n]) <= by * Math.max(1, Math.abs(x)), `${a} is not ${b}`));
const KINDS = ["triangle", "box", "ellipse", "polygon"];
const AXES = [
  { variable: "value", low: -1000, high: 3000 },
  { variable: "gradient", low: 0, high: 80 },
];
const THREE = [...AXES, { variable: "second", low: -9, high: 9 }];
const somewhere = (axes = AXES) => [0, 1].map((n) => random(axes[n].low, axes[n].high));
const inside = (shape, axes = AXES) =>
  bounds(shape, axes).forEach(([low, high], n) => {
    assert.ok(
      low < high &&
        low >= axes[n].low - 1e-9 * (axes[n].high - axes[n].low) &&
        high <= axes[n].high + 1e-9 * (axes[n].high - axes[n].low),
      JSON.stringify(shape),
    );
  });

test("whatever is pulled and moved, shapes stay inside of the axes", () => {
  for (const kind of KINDS) {
    let shape = fresh(kind, AXES, somewhere(), [1, 0, 0], 1);
    for (let n = 0; n < 300; n++) {
      const all = handles(shape, AXES);
      const wild = [random(-3000, 6000), random(-60, 150)];
      shape =
        n % 3
          ? pulled(shape, AXES, all[n % all.length].name, wild)
          : shifted(shape, AXES, [random(-2000, 2000), random(-50, 50)]);
      inside(shape);
      assert.deepEqual(Object.keys(fitted(shape, AXES)).sort(), Object.keys(shape).sort());
    }
  }
});

test("a handle goes where it is put, and others stay", () => {
  const box = fresh("box", AXES, [500, 40], [1, 1, 1], 1);
  const moved = pulled(box, AXES, "high high", [1200, 60]);
  assert.deepEqual([moved.low, moved.high], [box.low, [1200, 60]]);
  const triangle = pulled(fresh("triangle", AXES, [500, 40], [1, 1, 1], 1), AXES, "right", [900, 70]);
  close([triangle.value, triangle.half_width, triangle.top], [500, 400, 70]);
  const turned = pulled(fresh("ellipse", AXES, [500, 40], [1, 1, 1], 1), AXES, "first", [500, 50]);
  close(turned.radii, [0.005 * 4000, 8]); // its first radius has no length along that way
  const polygon = pulled(fresh("polygon", AXES, [500, 40], [1, 1, 1], 1), AXES, "vertex 2", [900, 70]);
  assert.deepEqual(polygon.vertices[2], [900, 70]);
});

test("an ellipse turns with its handle, and comes back", () => {
  let shape = fresh("ellipse", AXES, [1000, 40], [1, 1, 1], 1);
  for (let n = 0; n < 40; n++) {
    const wanted = { ...shape, angle_rad: random(-3, 3) };
    shape = pulled(shape, AXES, "turn", handles(wanted, AXES).find((one) => one.name === "turn").at);
    close([shape.angle_rad], [wanted.angle_rad], 1e-6);
  }
});

test("moving keeps the size, and carries the colour ramp", () => {
  for (const kind of KINDS) {
    const shape = {
      ...fresh(kind, AXES, [500, 40], [1, 0, 0], 1),
      ramp: {
        axis: 0,
        points: [
          [300, [1, 0, 0]],
          [700, [0, 1, 0]],
        ],
      },
    };
    const [before, after] = [shape, shifted(shape, AXES, [150, -5])].map((one) => bounds(one, AXES));
    before.forEach(([low, high], n) => close(after[n], [low + [150, -5][n], high + [150, -5][n]]));
    close(
      shifted(shape, AXES, [150, -5]).ramp.points.map((p) => p[0]),
      [450, 850],
    );
  }
});

test("the pointer hits the uppermost shape at a place", () => {
  for (const kind of KINDS) {
    const shape = fresh(kind, AXES, [500, 40], [1, 0, 0], 1);
    assert.ok(holds(shape, AXES, [500, 41]));
    for (const [x, y] of outline(shape, AXES)) {
      assert.ok(holds(shape, AXES, [500 + 0.98 * (x - 500), 41 + 0.98 * (y - 41)]), kind);
      assert.ok(!holds(shape, AXES, [500 + 1.05 * (x - 500), 41 + 1.05 * (y - 41)]), kind);
    }
    assert.ok(core(shape) === null || (core(shape) > 0 && core(shape) < 1));
  }
  const both = [fresh("box", AXES, [500, 40], [1, 0, 0], 1), fresh("ellipse", AXES, [500, 40], [1, 0, 0], 1)];
  assert.equal(hit(both, AXES, [500, 40]), 1);
  assert.equal(
    hit(
      both,
      AXES,
      both[0].low.map((x) => x + 0.1),
    ),
    0,
  );
  assert.equal(hit(both, AXES, [2900, 1]), -1);
});

test("a third axis comes, is narrowed and goes", () => {
  for (const kind of KINDS) {
    const flat = fresh(kind, AXES, [500, 40], [1, 0, 0], 1);
    const deep = withVariables(flat, THREE);
    close(thirdOf(deep, THREE), [-9, 9]);
    const narrow = withThird(deep, THREE, [4, -2]);
    close(thirdOf(narrow, THREE), [-2, 4]);
    close(thirdOf(shifted(narrow, THREE, [10, 1]), THREE), [-2, 4]);
    const again = withVariables(narrow, AXES);
    assert.deepEqual(
      Object.keys(again)
        .filter((name) => again[name] !== undefined)
        .sort(),
      Object.keys(flat).sort(),
    );
    assert.deepEqual(bounds(again, AXES), bounds(flat, AXES));
    const [low, high] = thirdOf(withThird(deep, THREE, [20, 30]), THREE);
    assert.ok(low < high && high <= 9);
  }
});

test("corners are added and taken away, and lists put in order", () => {
  const shape = fresh("polygon", AXES, [500, 40], [1, 0, 0], 1);
  const more = withCorner(shape, AXES);
  assert.equal(more.vertices.length, 5);
  close(bounds(more, AXES).flat(), bounds(shape, AXES).flat());
  let fewer = more;
  for (let n = 0; n < 9; n++) fewer = withoutCorner(fewer, AXES, 0);
  assert.equal(fewer.vertices.length, 3);
  inside(fewer);
  assert.deepEqual(reordered(["a", "b", "c"], 0, 2), ["b", "c", "a"]);
  assert.deepEqual(reordered(["a", "b", "c"], 2, -1), ["c", "a", "b"]);
  assert.equal(written(0.123456, 0.5), "0.1235");
  assert.equal(written(1234.56, 4000), "1235");
});

test("places in slices and points of the world are the same", () => {
  const camera = { name: "perspective", eye: [3, -9, 2], target: [0, 0, 0], up: [0, 0, 1], fov_deg: 30 };
  for (const [name, normal] of [
    ["axial"],
    ["coronal"],
    ["sagittal"],
    ["oblique"],
    ["oblique", [0.3, 0.2, 1]],
    ["oblique", [0, 0, 1]],
  ]) {
    const { right, up } = waysOf(name, camera, normal);
    close([length(right), length(up), dot(right, up)], [1, 1, 0]);
    if (normal) close(cross(right, up), unit(normal));
    const at = { centre: [4, 5, 6], right, up, pixel: 0.3 };
    const place = [random(0, 200), random(0, 100)];
    close(placeOf(at, [200, 100], worldAt(at, [200, 100], place)), place, 1e-9);
  }
  const facing = waysOf("oblique", camera, null);
  assert.ok(dot(cross(facing.right, facing.up), camera.eye) > 0);
});

test("a step through slices passes one voxel, sheared or not", () => {
  const matrix = [
    [2, 0.5, 0, 7],
    [0, 3, 0.2, 8],
    [0, 0, 0.5, 9],
    [0, 0, 0, 1],
  ];
  const rows = inverseRows(matrix);
  [0, 1, 2].forEach((axis) =>
    close(
      rows.map((row) =>
        dot(
          row,
          [0, 1, 2].map((n) => matrix[n][axis]),
        ),
      ),
      [0, 1, 2].map((n) => Number(n === axis)),
    ),
  );
  const direction = unit([0.1, 0.3, 1]);
  const step = times(direction, voxelStep(rows, direction));
  close([Math.max(...rows.map((row) => Math.abs(dot(row, step))))], [1]);
});

test("what the session keeps of a function is known again, defaults or not", () => {
  const sent = { axes: AXES, shapes: [{ ...fresh("triangle", AXES, [500, 40], [1, 0, 0], 1), edge: 1 }] };
  const { edge: _edge, ...plain } = sent.shapes[0];
  assert.ok(agrees({ ...sent, shapes: [plain] }, sent));
  assert.ok(!agrees({ ...sent, shapes: [{ ...plain, top: 3 }] }, sent));
  assert.ok(!agrees({ ...sent, shapes: [] }, sent));
  assert.ok(!agrees(undefined, sent));
});

test("a cut at the cross-hair is one clip, answered or not", () => {
  const volume = { low_world: [0, 0, 0], high_world: [10, 10, 10] };
  const cut = (x) => corner([x, 5, 5], [99, 5, -9], volume);
  const other = { kind: "plane", normal: [0, 0, 1] };
  const known = new Set([4, 6].map((x) => JSON.stringify([cut(x).low, cut(x).high])));
  assert.ok(cut(4).low[0] === 4 && cut(4).high[0] > 10 && cut(4).low[2] < 0 && cut(4).high[2] === 5);
  assert.deepEqual(replacedClips([other], known, cut(6)), [other, cut(6)]);
  assert.deepEqual(replacedClips([cut(4), other], known, cut(6)), [cut(6), other]);
  assert.deepEqual(replacedClips([cut(4), other, cut(6)], known, null), [other]);
});

test("black and white differ whatever the volume holds", () => {
  const chosen = (robust_range, range) => usualWindow({ robust_range, range });
  assert.deepEqual(chosen([2, 5], [0, 9]), [2, 5]);
  assert.deepEqual(chosen([0, 0], [0, 900]), [0, 900]); // next to everything is 0
  for (const value of [0, 1e-9, -3, 1e20]) {
    const [black, white] = chosen([value, value], [value, value]);
    assert.ok(white > black);
  }
});

test("places are written as finely as voxels lie", () => {
  assert.equal(placeText([12.34567, 0, -1], { spacing: [1, 1, 1.5], units: "mm" }), "12.3, 0.0, -1.0 mm");
  assert.equal(placeText([2.5e-7, 0, 0], { spacing: [1e-7, 1e-6, 1], units: "m" }), "0.00000025, 0.00000000, 0.00000000 m");
  assert.equal(placeText([1200.4, 0, 3], { spacing: [200, 200, 200], units: "um" }), "1200, 0, 3 µm");
});
