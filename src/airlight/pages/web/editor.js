// The editor of the transfer function: points over the histogram, by pointer and by keys, in data units.

import { add } from "./camera.js";
import { added, besides, moved, nudged, recoloured, removed } from "./points.js";
import { extinctionAt, heightOf, hexOf, inWords, rgbOf, ticks } from "./scales.js";

const SVG = "http://www.w3.org/2000/svg";
const PAD = { left: 10, right: 10, top: 12, bottom: 22 };
const FINGER_PX = 24;
const NEAR_PX = 12;
const ROOM = 1.5; // of the axis of extinctions above the greatest

/** An element with attributes, listeners (`onclick`) and children; texts are texts. */
function h(name, attributes = {}, ...children) {
  const isDrawn = ["svg", "g", "path", "line", "text", "circle", "defs", "linearGradient", "stop"].includes(name);
  const element = isDrawn ? document.createElementNS(SVG, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

/** The editor of a page's points as an element, over how many texels have which value; `changed` is called with new points. */
export function editor(page, points, counts, changed) {
  const { range } = page.volume;
  const { value_unit: valueUnit, units } = page;
  const first = page.transfer.points;
  const shown = [Math.min(range[0], points[0][0]), Math.max(range[1], points[points.length - 1][0])];
  const most = Math.max(...points.map((p) => p[2]));
  let top = ROOM * most || 1;
  let chosen = points.reduce((best, p, n) => (p[2] > points[best][2] ? n : best), 0);
  let size = [600, 150];
  const perLength = `per ${units || "unit"}`;

  const x = (value) => PAD.left + ((value - shown[0]) / (shown[1] - shown[0] || 1)) * (size[0] - PAD.left - PAD.right);
  const y = (extinction) => size[1] - PAD.bottom - heightOf(extinction, top) * (size[1] - PAD.top - PAD.bottom);
  const valueAt = (px) => shown[0] + ((px - PAD.left) / (size[0] - PAD.left - PAD.right)) * (shown[1] - shown[0]);
  const extinctionOf = (px) => extinctionAt((size[1] - PAD.bottom - px) / (size[1] - PAD.top - PAD.bottom), top);

  const svg = h("svg", { class: "curve", role: "group", "aria-label": "Transfer function: opacity and colour by value" });
  const number = (label, onchange) => h("input", { type: "number", step: "any", "aria-label": label, onchange });
  const valueInput = number("Value of the point", () => {
    const [value, , extinction] = points[chosen];
    put(moved(points, chosen, read(valueInput, value), extinction));
  });
  const extinctionInput = number("Extinction of the point", () => {
    const [value, , extinction] = points[chosen];
    put(moved(points, chosen, value, read(extinctionInput, extinction)));
  });
  const colourInput = h("input", {
    type: "color",
    "aria-label": "Colour of the point",
    oninput: () => put(recoloured(points, chosen, rgbOf(colourInput.value))),
  });
  const addButton = h("button", { type: "button", onclick: () => insert(besides(points, chosen)) }, "Add point");
  const removeButton = h("button", { type: "button", onclick: () => take() }, "Remove");
  const resetButton = h("button", { type: "button", onclick: () => { chosen = 0; put(first); } }, "Reset");
  const tools = h("div", { class: "tools" },
    h("label", {}, valueInput, h("span", {}, valueUnit || "value")),
    h("label", {}, extinctionInput, h("span", {}, perLength)),
    colourInput, addButton, removeButton, resetButton);

  function read(input, otherwise) {
    const found = input.valueAsNumber;
    return Number.isFinite(found) ? found : otherwise;
  }

  function put(next) {
    points = next;
    chosen = Math.min(chosen, points.length - 1);
    top = Math.max(top, ...points.map((p) => p[2]));
    draw();
    changed(points);
  }

  function insert(value) {
    const made = added(points, value);
    chosen = made.index;
    put(made.points);
    focus();
  }

  function take() {
    put(removed(points, chosen));
    focus();
  }

  const focus = () => svg.querySelector(`[data-point="${chosen}"]`)?.focus();

  function drag(event, index) {
    chosen = index;
    const box = svg.getBoundingClientRect();
    const place = (e) => [e.clientX - box.left, e.clientY - box.top];
    const off = add(place(event), [x(points[index][0]), y(points[index][2])], -1);
    const go = (e) => {
      const [u, v] = add(place(e), off, -1);
      put(moved(points, index, valueAt(u), Math.min(extinctionOf(v), top)));
    };
    const stop = () => {
      svg.removeEventListener("pointermove", go);
      svg.removeEventListener("pointerup", stop);
      svg.removeEventListener("pointercancel", stop);
    };
    svg.setPointerCapture(event.pointerId);
    svg.addEventListener("pointermove", go);
    svg.addEventListener("pointerup", stop);
    svg.addEventListener("pointercancel", stop);
    draw();
    focus();
    event.preventDefault();
  }

  function press(event, index) {
    chosen = index;
    if (event.key === "Delete" || event.key === "Backspace") take();
    else if (event.key === "Insert") insert(besides(points, index));
    else {
      const next = nudged(points, index, event.key, shown, top, event.shiftKey);
      if (!next) return;
      put(next);
    }
    focus();
    event.preventDefault();
  }

  function handle([value, rgb, extinction], index) {
    const words = `${inWords(value)} ${valueUnit}, extinction ${inWords(extinction)} ${perLength}`;
    return h("circle", {
      cx: x(value), cy: y(extinction), r: index === chosen ? 8 : 6, fill: hexOf(rgb), class: index === chosen ? "chosen" : "",
      tabindex: 0, role: "slider", "data-point": index, "aria-label": `Point ${index + 1} of ${points.length}`,
      "aria-valuemin": shown[0], "aria-valuemax": shown[1], "aria-valuenow": value, "aria-valuetext": words,
      onpointerdown: (event) => drag(event, index),
      onkeydown: (event) => press(event, index),
      onfocus: () => { if (chosen !== index) { chosen = index; draw(); focus(); } },
    }, h("title", {}, words));
  }

  function draw() {
    const [width, height] = size;
    const base = height - PAD.bottom;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const peak = Math.log1p(Math.max(...counts));
    const bar = (count, n) => {
      const [left, right] = [n, n + 1].map((m) => x(range[0] + (m / counts.length) * (range[1] - range[0])));
      const up = base - (Math.log1p(count) / peak) * (base - PAD.top);
      return `L${left.toFixed(1)} ${up.toFixed(1)}L${right.toFixed(1)} ${up.toFixed(1)}`;
    };
    // Extinction is linear between points, and the axis is not.
    const line = points.flatMap(([value, , extinction], n) => {
      const [next, , to] = points[n + 1] ?? [value, null, extinction];
      return [0, 0.1, 0.3, 0.6].map((w) => [x(value + w * (next - value)), y(extinction + w * (to - extinction))]);
    });
    const all = [[PAD.left, y(points[0][2])], ...line, [width - PAD.right, y(points[points.length - 1][2])]];
    const path = all.map(([u, v], n) => `${n ? "L" : "M"}${u.toFixed(1)} ${v.toFixed(1)}`).join("");
    const share = (value) => Math.min(Math.max((x(value) - PAD.left) / (width - PAD.left - PAD.right), 0), 1);
    const stops = points.map(([value, rgb]) => h("stop", { offset: share(value), "stop-color": hexOf(rgb) }));
    const marks = ticks(shown[0], shown[1], Math.max(2, width / 110)).map((value) =>
      h("text", { x: x(value), y: height - 6, "text-anchor": "middle" }, `${inWords(value)}`));
    const drawn = [
      h("defs", {}, h("linearGradient", { id: "colours" }, ...stops)),
      h("path", { class: "histogram", d: `M${x(range[0])} ${base}${[...counts].map(bar).join("")}L${x(range[1])} ${base}Z` }),
      h("path", { class: "area", fill: "url(#colours)", d: `${path}L${width - PAD.right} ${base}L${PAD.left} ${base}Z` }),
      h("path", { class: "line", d: path }),
      h("line", { class: "axis", x1: PAD.left, x2: width - PAD.right, y1: base, y2: base }),
      ...marks,
    ];
    const hadFocus = svg.contains(document.activeElement);
    svg.replaceChildren(...drawn, ...points.map(handle));
    if (hadFocus) focus();
    const [value, rgb, extinction] = points[chosen];
    valueInput.value = inWords(value);
    extinctionInput.value = inWords(extinction);
    colourInput.value = hexOf(rgb);
    removeButton.disabled = points.length <= 2;
  }

  // A finger need not hit a point exactly.
  svg.addEventListener("pointerdown", (event) => {
    if (event.target.getAttribute("role") === "slider") return;
    const box = svg.getBoundingClientRect();
    const apart = points.map((p) => Math.hypot(event.clientX - box.left - x(p[0]), event.clientY - box.top - y(p[2])));
    const nearest = apart.indexOf(Math.min(...apart));
    if (apart[nearest] < (event.pointerType === "touch" ? FINGER_PX : NEAR_PX)) drag(event, nearest);
  });
  svg.addEventListener("dblclick", (event) => {
    if (event.target.getAttribute("role") !== "slider") insert(valueAt(event.clientX - svg.getBoundingClientRect().left));
  });
  new ResizeObserver(([{ contentRect }]) => {
    if (!contentRect.width) return;
    size = [contentRect.width, contentRect.height];
    draw();
  }).observe(svg);
  return h("section", { class: "editor", "aria-label": "Transfer function" }, svg, tools);
}
