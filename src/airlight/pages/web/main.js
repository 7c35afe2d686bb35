// The page: the still picture first, then the volume, coarser while it moves and in full at rest.

import { GESTURES, within } from "./camera.js";
import { editor } from "./editor.js";
import { listen } from "./gestures.js";
import { openDevice, renderer } from "./gpu.js";
import { bytesOf } from "./packing.js";
import { histogram, unpacked } from "./volume.js";

const MOVING_MS = 40;
const REST_MS = 160;
const SCALES = [1, 0.75, 0.5, 0.35, 0.25];
const MOST_PX = 1 << 22;
const BINS = 256;
const BLACK = [0, 0, 0];
const ATTEMPTS = 2;

const at = (id) => document.getElementById(id);
const root = document.documentElement;
const page = JSON.parse(at("page").textContent);
const view = at("view");
const shown = { camera: page.camera, function: page.transfer };
let kept = null; // packed texels: a device that is lost takes its texture with it

/** Say what is the matter; the still picture is seen where nothing can be drawn. */
function say(words, isStill) {
  at("status").textContent = words;
  if (isStill) {
    root.dataset.drawn = "still";
    at("canvas").hidden = true;
    at("still").hidden = false;
    at("tools").replaceChildren();
  }
}

/** Whole pixels of the screen that the canvas has room for, and its own: fewer only on very large screens. */
function canvasSize() {
  const { width, height } = view.getBoundingClientRect();
  const screen = [width, height].map((n) => Math.max(1, Math.floor(n * devicePixelRatio)));
  const scale = Math.min(1, Math.sqrt(MOST_PX / (screen[0] * screen[1])));
  return { screen, own: screen.map((n) => Math.max(1, Math.floor(n * scale))) };
}

/** The texels that the page carries, behind this script, so that the device is asked for meanwhile; their text is let go. */
async function carriedTexels() {
  if (document.readyState === "loading") {
    await new Promise((done) => { document.addEventListener("DOMContentLoaded", done, { once: true }); });
  }
  kept ??= bytesOf(at("texels").textContent);
  at("texels")?.remove();
  return unpacked(kept, page.volume);
}

/** Draw on a new device; camera and function stay when one was lost. */
async function start(attempt) {
  const carried = carriedTexels();
  const device = await openDevice();
  const canvas = at("canvas").cloneNode(); // a canvas belongs to its first device
  canvas.hidden = false;
  at("canvas").replaceWith(canvas);
  const drawing = await renderer(device, page, carried, canvas, page.background ?? BLACK);
  if (shown.function) drawing.setFunction(shown.function);

  let version = 1; // of what is wanted; `data-drawn` tells what is seen of it: changing, coarse, full or still
  let presented = 0;
  let isFull = false;
  let lastInput = -Infinity;
  let isOver = false;
  let sizeSeen = null;
  let wake = () => {};

  function change() {
    if (isOver) return;
    version++;
    root.dataset.drawn = "changing";
    lastInput = performance.now();
    wake();
  }

  function look(camera) {
    shown.camera = camera;
    change();
  }

  function end(words) {
    if (isOver) return;
    isOver = true;
    sizes.disconnect();
    wake();
    if (words) say(`${words}, so this is a still picture.`, true);
    else begin(attempt + 1);
  }

  const gesture = ({ kind, dx, dy }) => look(within(GESTURES[kind](shown.camera, dx, dy), page.camera));
  listen(canvas, gesture, () => look(page.camera));
  at("view-reset").onclick = () => look(page.camera);
  const sizes = new ResizeObserver(() => {
    const size = String(canvasSize().screen);
    if (sizeSeen !== null && size !== sizeSeen) change();
    sizeSeen = size;
  });
  sizes.observe(view);
  device.addEventListener("uncapturederror", ({ error }) => {
    end(`The graphics device refused to draw (${error.message.slice(0, 200)})`);
  });
  device.lost.then(({ message }) => end(attempt < ATTEMPTS ? "" : `The graphics device was lost (${message})`));

  if (shown.function) {
    const counts = histogram(await carried, page.volume, page.volume.range, BINS);
    at("tools").replaceChildren(editor(page, shown.function.points, counts, (points) => {
      shown.function = { ...shown.function, points };
      drawing.setFunction(shown.function);
      change();
    }));
  }

  const scaled = (scale) => canvasSize().own.map((n) => Math.max(1, Math.round(n * scale)));
  const fits = (scale) => scaled(scale).reduce((a, b) => a * b) <= drawing.pixelsIn(MOVING_MS);
  const paint = async (scale, mine, isWanted) => {
    const [{ screen, own }, sizePx] = [canvasSize(), scaled(scale)];
    if (!(await drawing.draw(shown.camera, sizePx, scale === 1, isWanted)) || isOver) return false;
    ["width", "height"].forEach((side, n) => {
      if (canvas[side] !== own[n]) canvas[side] = own[n];
      canvas.style[side] = `${screen[n] / devicePixelRatio}px`;
    });
    drawing.present(sizePx);
    if (!at("still").hidden) performance.mark("first picture");
    at("still").hidden = true;
    root.dataset.drawn = version !== mine ? "changing" : scale === 1 ? "full" : "coarse";
    say("", false);
    return true;
  };

  while (!isOver) {
    const mine = version;
    if (presented !== mine) {
      const scale = SCALES.find(fits) ?? SCALES[SCALES.length - 1];
      if (!(await paint(scale, mine, () => !isOver))) continue;
      presented = mine;
      isFull = scale === 1;
      await new Promise(requestAnimationFrame);
    } else if (!isFull) {
      await new Promise((done) => setTimeout(done, Math.max(0, lastInput + REST_MS - performance.now())));
      if (version === mine) isFull = await paint(1, mine, () => version === mine && !isOver);
    } else {
      await new Promise((done) => { wake = done; });
    }
  }
}

function begin(attempt) {
  start(attempt).catch((error) => say(error.message || String(error), true));
}

say("Getting ready …", false);
begin(1);
