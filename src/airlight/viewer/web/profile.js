// The profile of a ray as a plot: value, extinction and opacity along it, with a mark that is moved along the ray in the view.
import { h, fill } from "./dom.js";
import { layersOf } from "./layers.js";

const [WIDE, HIGH] = [300, 120];
const CURVES = [
  ["value", "value"],
  ["extinction", "extinction"],
  ["opacity", "opacity"],
];

/** { element, ask(found), mark(), on(listener) }: mark() is what shows the place of the mark above the picture. */
export function makeProfile(view) {
  const lines = Object.fromEntries(CURVES.map(([name]) => [name, h("path", { class: `profile-${name}` })]));
  const cursor = h("line", {
    class: "profile-cursor",
    y1: 0,
    y2: HIGH,
    tabindex: 0,
    role: "slider",
    "aria-label": "place along the ray",
  });
  const mean = h("line", { class: "profile-mean", y1: 0, y2: HIGH });
  const svg = h(
    "svg",
    { class: "profile-plot", viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none" },
    Object.values(lines),
    mean,
    cursor,
  );
  const words = h("p", { class: "help profile-words" });
  const ends = h("p", { class: "profile-ends" });
  const legend = h(
    "p",
    { class: "profile-legend", "aria-hidden": "true" },
    CURVES.map(([name, word]) => h("span", { class: `profile-${name}` }, word)),
  );
  const element = h(
    "figure",
    { class: "profile", hidden: true, "aria-label": "Profile along the ray" },
    svg,
    ends,
    legend,
    words,
  );
  let told = null;
  let n = 0;
  let listener = () => {};

  async function ask({ x, y, layer, t_world }) {
    try {
      const found = await view.ask("profile", { x, y, layer: layer ?? layersOf(view).index() });
      told = found.count ? rowsOf(found) : null;
    } catch (error) {
      told = null;
      view.tell("error", error);
    }
    element.hidden = !told;
    if (!told) return listener();
    show();
    put(nearest(told.t, t_world ?? told.t_mean ?? told.t[0]));
  }

  function show() {
    const { t, value, extinction, opacity } = told;
    const x = (k) => (WIDE * (t[k] - t[0])) / (t.at(-1) - t[0] || 1);
    const [low, high] = extent(value);
    const path = (row, from, to) => {
      let pen = "M";
      return Array.from(row, (y, k) => {
        if (!Number.isFinite(y)) return ((pen = "M"), "");
        const part = `${pen}${x(k).toFixed(1)} ${(HIGH - 2 - ((HIGH - 4) * (y - from)) / (to - from || 1)).toFixed(1)}`;
        pen = "L";
        return part;
      }).join("");
    };
    lines.value.setAttribute("d", path(value, low, high));
    lines.extinction.setAttribute("d", path(extinction, 0, extent(extinction)[1]));
    lines.opacity.setAttribute("d", path(opacity, 0, 1));
    mean.style.display = told.t_mean === null ? "none" : "";
    const at = told.t_mean === null ? 0 : (WIDE * (told.t_mean - t[0])) / (t.at(-1) - t[0] || 1);
    mean.setAttribute("x1", at);
    mean.setAttribute("x2", at);
    fill(
      ends,
      h("span", {}, `${short(t[0])} ${told.units}`),
      h("span", {}, `values ${short(low)} to ${short(high)} ${told.value_unit}`),
      h("span", {}, `${short(t.at(-1))} ${told.units}`),
    );
  }

  const put = (k) => {
    n = Math.max(0, Math.min(told.t.length - 1, k));
    const x = (WIDE * (told.t[n] - told.t[0])) / (told.t.at(-1) - told.t[0] || 1);
    cursor.setAttribute("x1", x);
    cursor.setAttribute("x2", x);
    const value = Number.isFinite(told.value[n]) ? `${short(told.value[n])} ${told.value_unit}`.trim() : "empty";
    const seen = `extinction ${short(told.extinction[n])}, opacity ${told.opacity[n].toFixed(3)}`;
    const text = `at ${short(told.t[n])} ${told.units}: value ${value}, ${seen}`;
    words.textContent =
      text + (told.t_mean === null ? "" : `; mean depth, weighted by opacity, ${short(told.t_mean)} ${told.units}`);
    cursor.setAttribute("aria-valuetext", text);
    cursor.setAttribute("aria-valuenow", told.t[n]);
    cursor.setAttribute("aria-valuemin", told.t[0]);
    cursor.setAttribute("aria-valuemax", told.t.at(-1));
    listener();
  };
  const drag = (event) => {
    if (!told || !(event.buttons & 1)) return;
    const box = svg.getBoundingClientRect();
    const part = (event.clientX - box.left) / box.width;
    put(nearest(told.t, told.t[0] + part * (told.t.at(-1) - told.t[0])));
  };
  svg.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    cursor.focus({ preventScroll: true });
    svg.setPointerCapture(event.pointerId);
    drag(event);
  });
  svg.addEventListener("pointermove", drag);
  cursor.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -20, PageUp: 20 }[event.key];
    if (!step || !told) return;
    event.preventDefault();
    event.stopPropagation();
    put(n + step);
  });

  const mark = () => {
    if (!told) return null;
    const place = view.project(told.origin.map((x, axis) => x + told.t[n] * told.direction[axis]));
    return place && h("path", { class: "profile-mark", d: `M${place[0] - 7} ${place[1]}h14M${place[0]} ${place[1] - 7}v14` });
  };
  return { element, ask, mark, on: (heard) => (listener = heard) };
}

function rowsOf(found) {
  const {
    count,
    buffers: [buffer],
  } = found;
  const bytes = ArrayBuffer.isView(buffer)
    ? buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.byteLength)
    : buffer;
  const rows = new Float32Array(bytes);
  const row = (k) => rows.subarray(k * count, (k + 1) * count);
  return { ...found, t: row(0), extinction: row(1), opacity: row(2), value: row(3) };
}

const short = (x) => String(Number(x.toPrecision(4)));
const extent = (row) =>
  row
    .reduce(([a, b], y) => (Number.isFinite(y) ? [Math.min(a, y), Math.max(b, y)] : [a, b]), [Infinity, -Infinity])
    .map((x) => (Number.isFinite(x) ? x : 0));

function nearest(t, at) {
  let best = 0;
  t.forEach((x, k) => Math.abs(x - at) < Math.abs(t[best] - at) && (best = k));
  return best;
}
