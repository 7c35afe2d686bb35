// The plot of a joint histogram: counts as a picture, ticks in data units, and layers of SVG above it.
import { h, fill } from "../dom.js";

export const SIDE = 100; // of the plot, in units of its SVG
const COUNTS = [
  [16, 18, 22],
  [51, 70, 140],
  [107, 128, 204],
  [180, 191, 232],
  [255, 255, 255],
]; // as the library draws them

let count = 0;

/** Two axes as a square: places of coordinates in SVG units, and coordinates of places and of the pointer. */
export function placing(axes) {
  const span = (n) => axes[n].high - axes[n].low;
  const to = ([x, y]) => [(SIDE * (x - axes[0].low)) / span(0), SIDE * (1 - (y - axes[1].low) / span(1))];
  const from = ([x, y]) => [axes[0].low + (x / SIDE) * span(0), axes[1].low + (1 - y / SIDE) * span(1)];
  return { to, from, span };
}

/** A number as it is written beside an axis of some span. */
export const written = (value, span) =>
  String(Number(value.toFixed(Math.max(0, Math.min(12, 3 - Math.floor(Math.log10(span || 1)))))));

/** A plot: { element, svg, layers by name, show(axes, shades), at(event) }. */
export function makePlot(names, label) {
  const canvas = h("canvas", { class: "joint-counts", role: "img", "aria-label": label });
  const id = `airlight-joint-${++count}`;
  const layers = Object.fromEntries(names.map((name) => [name, h("g", { class: `joint-${name}` })]));
  const svg = h("svg", { class: "joint-above", viewBox: `0 0 ${SIDE} ${SIDE}` }, Object.values(layers));
  const across = h("div", { class: "joint-ticks joint-across", "aria-hidden": "true" });
  const upward = h("div", { class: "joint-ticks joint-upward", "aria-hidden": "true" });
  const element = h("div", { class: "joint-plot" }, upward, h("div", { class: "joint-square" }, canvas, svg), across);

  const ticks = (axis) => axis.ticks.map(([value, text]) => [(100 * (value - axis.low)) / (axis.high - axis.low), text]);
  const show = (axes, shades) => {
    const side = Math.sqrt(shades.length);
    if (canvas.width !== side) canvas.width = canvas.height = side;
    canvas.getContext("2d").putImageData(new ImageData(coloured(shades), side, side), 0, 0);
    fill(
      across,
      ticks(axes[0]).map(([part, text]) => placedText(text, "left", part)),
    );
    fill(
      upward,
      ticks(axes[1]).map(([part, text]) => placedText(text, "bottom", part)),
    );
  };
  const at = (event) => {
    const box = svg.getBoundingClientRect();
    return [(SIDE * (event.clientX - box.left)) / box.width, (SIDE * (event.clientY - box.top)) / box.height];
  };
  return { element, svg, layers, id, show, at };
}

function placedText(text, side, part) {
  const element = h("span", {}, text);
  element.style[side] = `${part}%`;
  return element;
}

/** Colours of shades of grey, from none to the most. */
function coloured(shades) {
  const table = Array.from({ length: 256 }, (_, shade) => {
    const at = (shade / 255) * (COUNTS.length - 1);
    const n = Math.min(Math.floor(at), COUNTS.length - 2);
    return COUNTS[n].map((c, m) => c + (at - n) * (COUNTS[n + 1][m] - c));
  });
  const pixels = new Uint8ClampedArray(4 * shades.length);
  shades.forEach((shade, n) => pixels.set([...table[shade], 255], 4 * n));
  return pixels;
}
