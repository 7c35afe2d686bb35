// Gestures on their way, and what is told of the picture, without a page.
import assert from "node:assert/strict";
import test from "node:test";

import { bound, joined, piled } from "../../../src/airlight/viewer/web/gestures.js";
import { byMeaning, groupsOf, madeBy } from "../../../src/airlight/viewer/web/help.js";
import { heldGesture, keyName } from "../../../src/airlight/viewer/web/keys.js";
import { statusText } from "../../../src/airlight/viewer/web/overlay.js";
import { paired, pairOf, wheeled } from "../../../src/airlight/viewer/web/pointer.js";
import { directionName, facesOf, lengthText, partsOf, roundBelow, scaleBar, seenFrom, shownHeight } from "../../../src/airlight/viewer/web/seen.js";
import { cross, dot, unit } from "../../../src/airlight/viewer/web/vectors.js";
import { makeView, projected } from "../../../src/airlight/viewer/web/view.js";

let seed = 3;
const random = (low = -1, high = 1) => low + ((high - low) * (seed = (seed * 48271) % 2147483647)) / 2147483647;
const near = (a, b, by = 1e-9) => assert.ok(Math.abs(a - b) <= by * Math.max(1, Math.abs(b)), `${a} is not ${b}`);
const camera = (eye, more = {}) => ({ name: "perspective", eye, target: [0, 0, 0], up: [0, 0, 1], fov_deg: 30, ...more });

test("gestures of a frame add up, and nothing overtakes what stands between", () => {
  const sent = [];
  let later;
  const gesture = piled((message) => sent.push(message), (call) => (later = call));
  for (let n = 0; n < 10; n++) gesture({ kind: "orbit", dx: 0.1, dy: -0.2, stroke: 1 });
  gesture({ kind: "dolly", dy: 0.1, at: [0, 0] });
  gesture({ kind: "dolly", dy: 0.1, at: [1, 0] });
  gesture({ kind: "fit" });
  gesture({ kind: "orbit", dx: 1 });
  assert.equal(sent.length, 0);
  later();
  assert.equal(sent.length, 1);
  const [orbit, dolly, fit, last] = sent[0].all;
  near(orbit.dx, 1);
  near(orbit.dy, -2);
  assert.deepEqual([dolly.at, fit.kind, last.dx], [[1, 0], "fit", 1]);
  near(dolly.dy, 0.2);
  gesture({ kind: "pan", dx: 1 });
  later();
  assert.deepEqual(sent[1], { type: "gesture", kind: "pan", dx: 1 });
  assert.equal(joined([{ kind: "window", dx: 1, stroke: 1 }], { kind: "window", dx: 1, stroke: 2 }).length, 2);
});

test("the most particular entry is bound", () => {
  const table = [{ key: "a", kind: "one" }, { key: "a", modifier: "Shift", kind: "two" }, { key: "a", turning: "fly", kind: "three" }, { key: "z", modifier: "Control", kind: "four" }];
  const kind = (...given) => bound(table, "key", ...given)?.kind;
  assert.deepEqual([kind("a", [], ""), kind("a", ["Shift"], ""), kind("a", [], "fly"), kind("z", [], ""), kind("z", ["Meta"], "")], ["one", "two", "three", undefined, "four"]);
  assert.deepEqual([keyName({ key: "=" }), keyName({ key: "W" }), keyName({ key: "ArrowUp" })], ["+", "w", "ArrowUp"]);
  assert.deepEqual(heldGesture({ key: "w", kind: "fly", dz: 2, fast: 4 }, 0.5, true), { kind: "fly", dz: 4 });
});

test("two fingers pinch, drag and twist each by itself", () => {
  for (let n = 0; n < 100; n++) {
    const fingers = [{ x: random(0, 500), y: random(0, 500) }, { x: random(0, 500), y: random(0, 500) }];
    const before = pairOf(fingers);
    const [dx, dy, factor, angle] = [random(-50, 50), random(-50, 50), random(0.5, 2), random(-3, 3)];
    const turned = fingers.map(({ x, y }) => {
      const [u, v] = [(x - before.x) * factor, (y - before.y) * factor];
      return { x: before.x + dx + u * Math.cos(angle) - v * Math.sin(angle), y: before.y + dy + u * Math.sin(angle) + v * Math.cos(angle) };
    });
    const told = paired(before, pairOf(turned));
    near(told.dx, dx, 1e-6);
    near(told.dy, dy, 1e-6);
    near(Math.exp(2 * told.nearer), 1 / factor, 1e-6);
    near(told.turn, angle, 1e-6);
  }
});

test("wheels of lines and of pixels are as strong, and wild ones are bounded", () => {
  near(wheeled({ deltaY: 3, deltaMode: 1 }, 500), wheeled({ deltaY: 48, deltaMode: 0 }, 500));
  assert.ok(wheeled({ deltaY: 1e9, deltaMode: 0 }, 500) <= 0.25);
  assert.ok(wheeled({ deltaY: 3, deltaMode: 0, ctrlKey: true }, 500) > wheeled({ deltaY: 3, deltaMode: 0 }, 500));
});

test("scale bars are round, and as long as what they name", () => {
  for (let n = 0; n < 200; n++) {
    const most = 10 ** random(-6, 6);
    const round = roundBelow(most);
    assert.ok(round <= most * (1 + 1e-9) && round > most / 2.6, `${round} of ${most}`);
    assert.match(round.toExponential(6), /^[125]\.0+e/);
    const seen = camera([0, -(10 ** random(-2, 4)), 0], random() > 0 ? {} : { name: "orthographic", height: 10 ** random(-2, 4) });
    const bar = scaleBar(seen, 600, 150, "");
    assert.ok(bar.px <= 150.001 && bar.px > 50);
    // The bar is as long as two points at the target that are as far apart.
    const amount = Number(bar.text);
    const [a, b] = [[0, 0, 0], [amount, 0, 0]].map((p) => projected(seen, p, [800, 600]));
    near(b[0] - a[0], bar.px, 0.01);
  }
  assert.deepEqual([lengthText(0.05, "mm"), lengthText(2000, "mm"), lengthText(20, "µm"), lengthText(3, "")], ["50 µm", "2 m", "20 µm", "3"]);
  assert.equal(shownHeight({ name: "panorama" }), null);
});

test("directions are told in words, anatomical ones where they are known", () => {
  assert.equal(seenFrom(camera([0, -5, 0]), true), "from the front");
  assert.equal(seenFrom(camera([3, -3, 1]), true), "from the left, the front and slightly above");
  assert.equal(seenFrom(camera([0, 0, -5], { up: [0, 1, 0] }), false), "from −z");
  assert.equal(directionName([1, 1, -1], true), "left posterior inferior");
});

test("faces of the cube that are turned to the eye are seen, with letters that are not mirrored", () => {
  for (let n = 0; n < 100; n++) {
    const seen = camera([random(-9, 9), random(-9, 9), random(-9, 9)]);
    const toEye = unit(seen.eye);
    for (const face of facesOf(seen, true)) {
      assert.equal(face.turned, dot(face.direction, toEye) > 1e-6);
      assert.deepEqual(cross(face.aside, face.above).map((x) => x + 0), face.direction.map((x) => x + 0));
      const parts = partsOf(face);
      assert.equal(parts.length, 9);
      for (const part of parts) assert.ok(part.corners.every((corner) => corner.every((x) => Math.abs(x) <= 1)) && part.direction.every((x) => [-1, 0, 1].includes(x)));
    }
  }
  assert.deepEqual(new Set(facesOf(camera([5, -4, 3]), true).flatMap(partsOf).map((part) => part.direction.join())).size, 26);
});

test("help and status are read from what makes them", () => {
  const table = [{ pointer: "left", modifier: "Control", kind: "window", help: "window" }, { key: "ArrowUp", kind: "orbit", help: "turn" }, { key: "w", turning: "fly", kind: "fly", help: "forward" }, { key: "ArrowDown", kind: "orbit", help: "turn" }];
  assert.deepEqual(madeBy(table[0]), ["Ctrl", "drag"]);
  assert.deepEqual(groupsOf(table).map((group) => group.entries.length), [1, 2, 1]);
  assert.deepEqual(byMeaning(groupsOf(table)[1].entries).map(([help, all]) => [help, all.length]), [["turn", 2]]);
  assert.equal(statusText({ drawn_px: [512, 512], fps: 33.6, step: 2, final: false }), "512 × 512, 34 fps, step 2");
  assert.equal(statusText({ drawn_px: [512, 512], fps: 3, step: 1, final: true, refined: false }), "512 × 512, step 1, refining …");
});

test("whoever asks is answered, also where the connection is cut or not there", async () => {
  const heard = {};
  let there = true;
  const model = { send: () => there && undefined, on: (name, listener) => (heard[name] = listener) };
  const view = makeView(model, {}, {});
  const errors = [];
  view.on("error", (error) => errors.push(error.where));
  const asked = view.ask("files");
  heard["msg:closed"]();
  await assert.rejects(asked, { where: "connection" });
  there = false;
  await assert.rejects(view.ask("files"), { where: "connection" });
  heard["msg:closed"]();
  assert.deepEqual(errors, ["connection"]); // once, however often it is tried again
  there = true;
  heard["msg:open"]();
  const again = view.ask("files");
  heard["msg:custom"]({ type: "answer", id: 3, value: { folder: null } }, []);
  assert.deepEqual(await again, { folder: null, buffers: [] });
});
