// Pure functions of the editor of transfer functions.
import assert from "node:assert/strict";
import test from "node:test";

import { MOST_OPACITY, SCALES, extinctionOf, heights, holding, opacityOf, panned, roundUp, rounded, said, ticks, zoomed } from "../../../src/airlight/viewer/web/editor/axes.js";
import { joined, split } from "../../../src/airlight/viewer/web/editor/colors.js";
import { curveLine, histogramColumns } from "../../../src/airlight/viewer/web/editor/curve.js";
import { added, domain, evaluate, mainColour, moved, removed, tinted, windowed } from "../../../src/airlight/viewer/web/editor/points.js";
import { steady, stroke } from "../../../src/airlight/viewer/web/editor/steady.js";

let seed = 11;
const random = (low = 0, high = 1) => low + ((high - low) * (seed = (seed * 48271) % 2147483647)) / 2147483647;
const close = (a, b, by = 1e-9) => assert.ok(Math.abs(a - b) <= by * Math.max(1, Math.abs(a), Math.abs(b)), `${a} is not ${b}`);
const colour = (most = 1) => [random(0, most), random(0, most), random(0, most)];
function points(count = 2 + Math.floor(random(0, 7))) {
  const values = Array.from({ length: count }, () => Math.round(random(-1000, 3000))).sort((a, b) => a - b);
  if (random() > 0.5 && count > 2) values[1] = values[2]; // a step
  return values.map((value) => [value, colour(), random() > 0.3 ? random(0, 4) : 0]);
}
const isOrdered = (all) => all.every((point, n) => n === 0 || all[n - 1][0] <= point[0]);

test("heights come back on each scale, and small ones are lifted", () => {
  for (const scale of Object.keys(SCALES)) {
    for (const quantity of ["extinction", "opacity"]) {
      const axis = heights({ quantity, scale, top: 5, length: 0.7 });
      assert.equal(axis.to(0), 0);
      assert.equal(axis.from(0), 0);
      for (let n = 0; n < 100; n++) {
        const extinction = 5 * 10 ** random(-6, 0);
        close(axis.from(axis.to(extinction)) / extinction, 1, 1e-6);
        const y = random(0, 0.99);
        assert.ok(axis.to(axis.from(y)) - y < 1e-6);
      }
      if (scale !== "linear") assert.ok(axis.to(0.005) > 0.08);
    }
  }
});

test("an opacity is over a length, and never endless", () => {
  close(opacityOf(2, 0.5), 1 - Math.exp(-1));
  for (let n = 0; n < 50; n++) {
    const [opacity, length] = [random(0, 0.999), 10 ** random(-3, 3)];
    close(opacityOf(extinctionOf(opacity, length), length), opacity);
    close(opacityOf(extinctionOf(opacity, length), 2 * length), 1 - (1 - opacity) ** 2); // twice the way
  }
  assert.ok(Number.isFinite(extinctionOf(1, 1)));
  close(opacityOf(extinctionOf(1, 3), 3), MOST_OPACITY);
});

test("what is shown stays within limits and holds what it shall", () => {
  for (let n = 0; n < 200; n++) {
    const limits = holding([[random(-9, 0), random(1, 9)], [random(-20, 20), random(20, 30)]]);
    let range = limits;
    for (let k = 0; k < 6; k++) {
      const about = random(range[0], range[1]);
      const place = (about - range[0]) / (range[1] - range[0]);
      const next = zoomed(range, about, random(0.3, 0.9), limits);
      close((about - next[0]) / (next[1] - next[0]), place, 1e-6);
      range = panned(next, random(-50, 50), limits);
      assert.ok(range[0] >= limits[0] - 1e-9 && range[1] <= limits[1] + 1e-9);
    }
    assert.deepEqual(zoomed(range, range[0], 1e9, limits), limits);
  }
});

test("ticks are round and inside", () => {
  for (let n = 0; n < 100; n++) {
    const low = random(-5000, 5000);
    const high = low + 10 ** random(-3, 6);
    const marks = ticks(low, high, 5);
    assert.ok(marks.length >= 2 && marks.length <= 11);
    assert.ok(marks.every((mark) => mark >= low - 1e-6 * (high - low) && mark <= high + 1e-6 * (high - low)));
  }
  assert.deepEqual(ticks(0, 1, 4), [0, 0.5, 1]);
  assert.deepEqual(ticks(-1000, 2000, 4), [-1000, 0, 1000, 2000]);
  assert.equal(rounded(0.1 + 0.2, 0.01), 0.3);
  assert.equal(rounded(1234.5, 10), 1230);
  assert.deepEqual([0.021, 1, 3.1, 9.9].map(roundUp), [0.03, 1, 5, 10]);
  assert.deepEqual([0, 300, -0.02, 1234567, 0.0000123].map((value) => said(value)), ["0", "300", "-0.02", "1.23e6", "1.23e-5"]);
});

test("points keep their order however they are moved, added and removed", () => {
  for (let n = 0; n < 300; n++) {
    const before = points();
    const place = Math.floor(random(0, before.length - 1e-9));
    const after = moved(before, place, random(-4000, 5000), random(-1, 3));
    assert.ok(isOrdered(after));
    assert.ok(after[place][2] >= 0);
    assert.deepEqual(after.toSpliced(place, 1), before.toSpliced(place, 1));
    const value = random(-2000, 4000);
    const [more, at] = added(before, value);
    assert.ok(isOrdered(more));
    assert.equal(more[at][0], value);
    for (let k = 0; k < 5; k++) {
      const probe = random(-2000, 4000);
      close(evaluate(more, probe).extinction, evaluate(before, probe).extinction); // the curve stays
    }
    assert.deepEqual(removed(more, at), before);
  }
  const one = [[5, [1, 1, 1], 1]];
  assert.equal(removed(one, 0), one);
});

test("at a step the later point holds", () => {
  const step = [[0, [0, 0, 0], 0], [1, [0, 0, 0], 0], [1, [1, 0, 0], 4], [2, [1, 0, 0], 4]];
  assert.equal(evaluate(step, 1).extinction, 4);
  assert.equal(evaluate(step, 1 - 1e-12).extinction < 1e-9, true);
  const line = curveLine(step, [0, 2], 100, { to: (extinction) => extinction / 4 });
  const upright = line.filter(([x]) => x === 50).map(([, y]) => y);
  assert.deepEqual([upright.includes(0), upright.at(-1)], [true, 1]);
});

test("the curve that is drawn is the function", () => {
  for (let n = 0; n < 30; n++) {
    const own = points(5);
    const axis = heights({ quantity: "extinction", scale: "power", top: 4, length: 1 });
    for (const [x, y, isPoint] of curveLine(own, [-1000, 3000], 80, axis)) {
      if (isPoint === undefined) close(axis.from(y), evaluate(own, -1000 + 50 * x).extinction, 1e-6);
    }
  }
});

test("a window moves the whole function", () => {
  for (let n = 0; n < 100; n++) {
    const own = { points: points(4), surfaces: [{ value: 100, opacity: 1 }] };
    const [low, high] = domain(own.points);
    const next = windowed(own, 40, 80);
    if (high > low) {
      close(domain(next.points)[0], 0, 1e-6);
      close(domain(next.points)[1], 80, 1e-6);
      close((next.surfaces[0].value - 0) / 80, (100 - low) / (high - low), 1e-6);
    }
    assert.deepEqual(next.points.map((point) => point.slice(1)), own.points.map((point) => point.slice(1)));
    assert.ok(isOrdered(next.points));
  }
});

test("colours are exact where they are not changed", () => {
  for (let n = 0; n < 100; n++) {
    const rgb = colour(n % 2 ? 1 : 9);
    const { hex, glow } = split(rgb);
    assert.equal(joined(hex, glow, rgb), rgb);
    split(joined("#3366cc", glow)).glow <= glow + 1e-9 || assert.fail("brighter");
  }
  assert.deepEqual(split(joined("#ff9966", 4)), { hex: "#ff9966", glow: 4 });
  assert.deepEqual(mainColour([[0, [0, 0, 0], 0], [1, [0, 0.5, 0], 2]]), [0, 1, 0]);
  assert.deepEqual(tinted([[0, [0, 0.5, 0.25], 1]], [1, 0, 0]), [[0, [0.5, 0, 0], 1]]);
});

test("a histogram's highest bin is seen from however far", () => {
  const counts = Array.from({ length: 1000 }, (_, n) => (n === 357 ? 1000 : n % 3));
  const histogram = { counts, low: 0, high: 1000 };
  for (const log of [true, false]) {
    assert.equal(Math.max(...histogramColumns(histogram, [0, 1000], 50, log)), 1);
    assert.equal(histogramColumns(histogram, [350, 360], 100, log)[75], 1);
    assert.deepEqual(histogramColumns(histogram, [2000, 3000], 4, log), [0, 0, 0, 0]);
  }
});

test("of edits that come too fast the newest of a stroke is sent, and none of two strokes is lost", async () => {
  globalThis.requestAnimationFrame = (work) => setTimeout(work, 1);
  globalThis.cancelAnimationFrame = clearTimeout;
  const sent = [];
  const listeners = {};
  const ops = (ops, merge) => `id${sent.push([ops, merge])}`;
  const edits = steady({ ops, on: (name, listener) => (listeners[name] = listener) });
  for (let n = 0; n < 5; n++) edits.put(n, "a");
  await new Promise((resolve) => setTimeout(resolve, 10));
  assert.deepEqual(sent, [[4, "a"]]);
  edits.put(5, "a");
  await new Promise((resolve) => setTimeout(resolve, 10));
  assert.equal(sent.length, 1); // the session has not answered
  edits.put(6, "b");
  edits.put(7, "b");
  listeners.state({ answers: "id1" });
  assert.equal(edits.pending(), true);
  listeners.state({ answers: "" }); // of something else
  listeners.state({ answers: "id2" });
  await new Promise((resolve) => setTimeout(resolve, 10));
  assert.deepEqual(sent.slice(1), [[5, "a"], [7, "b"]]);
  edits.flush();
  listeners.state({ answers: "" });
  assert.equal(edits.pending(), true); // only what answers it ends the waiting
  listeners.state({ answers: "id3" });
  assert.equal(edits.pending(), false);
  edits.put(8, "c");
  edits.flush();
  listeners.welcome({}); // the connection was cut meanwhile
  assert.equal(edits.pending(), false);
  assert.notEqual(stroke("x"), stroke("x"));
});
