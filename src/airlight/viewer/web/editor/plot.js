// The plot of a function: its curve with points to drag, by pointer, touch and keys, over the histogram of the data.
import { h, fill } from "../dom.js";
import { heights, holding, opacityOf, panned, rounded, said, ticks, zoomed } from "./axes.js";
import { cssOf } from "./colors.js";
import { drawCurve, drawStrip } from "./curve.js";
import { added, domain, evaluate, moved, room } from "./points.js";
import { stroke } from "./steady.js";

const HEIGHT = 170;
const STRIP = 12;
const NEAR_PX = 9;
const KEY_PX = 3;
const FINE_PX = 0.3;
const MOST_HANDLES = 150;
const ZOOM = 0.8;

/** The plot: { element, show(what, isOther), select(n), selected(), focus(), mark(value), zoom(factor), fit(), busy(),
 * middle() }; points that were moved are told as they come, and null at the end of a drag. */
export function makePlot({ onpoints, onselect, ondelete }) {
  let what = null; // points, histogram, unit, lengthUnit, quantity, scale, length, top, log, limits, marks
  let range = null;
  let own = false; // whether the range was chosen by a user
  let selected = 0;
  let dragged = null;
  let pointed = null;
  let width = 0;
  let marked = null; // a value that was pointed at elsewhere

  const canvas = h("canvas", { class: "tf-canvas", "aria-hidden": "true" });
  const strip = h("canvas", { class: "tf-strip", "aria-hidden": "true" });
  const handles = h("div", { class: "tf-handles", role: "group", "aria-label": "Points of the transfer function" });
  const beside = h("div", { class: "tf-beside", "aria-hidden": "true" });
  const below = h("div", { class: "tf-below", "aria-hidden": "true" });
  const readout = h("p", { class: "tf-readout", "aria-hidden": "true" });
  const area = h("div", { class: "tf-area" }, canvas, beside, handles);
  const element = h("div", { class: "tf-plot" }, readout, area, strip, below);

  const axis = () => heights(what);
  const xOf = (value) => ((value - range[0]) / (range[1] - range[0])) * width;
  const valueAt = (x) => range[0] + ((range[1] - range[0]) * x) / width;
  /** Digits of a value that is dragged: a tenth of a pixel at most is rounded away. */
  const neat = (value) => rounded(value, 10 ** Math.floor(Math.log10((range[1] - range[0]) / width)));
  const whole = () => holding([what.limits, domain(what.points)]);
  const farthest = () => holding([what.limits, what.dataRange, domain(what.points)]);

  // -- words

  const valueWords = (value) => `${said(value)} ${what.unit}`.trim();
  const heightWords = (extinction) => {
    const percent = said(100 * opacityOf(extinction, what.length), 3);
    const over = `opacity ${percent} % over ${said(what.length)} ${what.lengthUnit}`;
    return `extinction ${said(extinction, 3)} per ${what.lengthUnit}, ${over}`;
  };
  const pointWords = ([value, rgb, extinction]) => [valueWords(value), heightWords(extinction), cssOf(rgb)].join(", ");

  function read() {
    if (pointed === null || dragged) return void (readout.textContent = pointWords(what.points[selected]));
    const { extinction } = evaluate(what.points, pointed);
    const { counts = [], low = 0, high = 1 } = what.histogram ?? {};
    const count = counts[Math.floor(((pointed - low) / (high - low)) * counts.length)];
    const samples = count === undefined ? [] : [`${count.toLocaleString("en")} samples`];
    readout.textContent = [valueWords(neat(pointed)), heightWords(extinction), ...samples].join(", ");
  }

  // -- drawing

  function sized(target, tall) {
    const ratio = globalThis.devicePixelRatio || 1;
    const [w, t] = [Math.round(width * ratio), Math.round(tall * ratio)];
    if (target.width !== w || target.height !== t) [target.width, target.height] = [w, t];
    const context = target.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    return context;
  }

  function redraw() {
    if (!what || !area.clientWidth) return;
    width = area.clientWidth;
    const style = getComputedStyle(element);
    const [ink, faint, accent] = ["--ink", "--faint", "--accent"].map((name) => style.getPropertyValue(name));
    const height = axis();
    const all = marked === null ? what.marks : [...what.marks, { value: marked, colour: accent }];
    drawCurve(sized(canvas, HEIGHT), { ...what, marks: all, width, height: HEIGHT, range, axis: height, ink, faint, accent });
    drawStrip(sized(strip, STRIP), { width, height: STRIP, range, points: what.points });
    fill(
      beside,
      height
        .ticks()
        .map(([y, number]) =>
          placed(h("span", {}, what.quantity === "opacity" ? `${said(100 * number)} %` : said(number)), 0, HEIGHT * (1 - y)),
        ),
    );
    const marks = ticks(range[0], range[1], Math.max(2, width / 64));
    fill(
      below,
      marks.map((value) => placed(h("span", {}, said(value)), xOf(value), 0)),
      h("span", { class: "tf-unit" }, what.unit),
    );
    placeHandles(height);
    read();
  }

  function placed(target, x, y) {
    target.style.transform = `translate(${x}px, ${y}px)`;
    return target;
  }

  function placeHandles(height) {
    const seen = what.points.map((_, n) => n).filter((n) => what.points[n][0] >= range[0] && what.points[n][0] <= range[1]);
    const few = seen.length <= MOST_HANDLES ? seen : seen.filter((n) => n === selected);
    const held = handles.contains(document.activeElement);
    while (handles.childElementCount < few.length) handles.append(handle());
    while (handles.childElementCount > few.length) handles.lastChild.remove();
    few.forEach((n, place) => {
      const point = what.points[n];
      const target = handles.children[place];
      target.dataset.point = n;
      target.classList.toggle("chosen", n === selected);
      placed(target, xOf(point[0]), HEIGHT * (1 - height.to(point[2])));
      target.firstChild.style.backgroundColor = cssOf(point[1]);
      const [low, high] = room(what.points, n);
      const told = {
        "aria-label": `point ${n + 1} of ${what.points.length}`,
        "aria-valuenow": point[0],
        "aria-valuetext": pointWords(point),
        "aria-valuemin": Math.max(low, range[0]),
        "aria-valuemax": Math.min(high, range[1]),
        tabindex: 0,
      };
      for (const [name, text] of Object.entries(told))
        if (target.getAttribute(name) !== String(text)) target.setAttribute(name, text);
    });
    if (held && !handles.contains(document.activeElement)) focus();
  }

  function handle() {
    const target = h("div", { class: "tf-handle", role: "slider" }, h("span", {}));
    const number = () => Number(target.dataset.point);
    target.addEventListener("focus", () => select(number()));
    target.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      event.stopPropagation();
      target.focus({ preventScroll: true });
      begin(event, number());
    });
    target.addEventListener("keydown", (event) => key(event, number()));
    target.addEventListener("blur", () => (nudged = null));
    return target;
  }

  // -- moving points

  function begin(event, n) {
    select(n);
    const [value, , extinction] = what.points[n];
    const box = area.getBoundingClientRect();
    dragged = {
      n,
      merge: stroke("points"),
      value,
      extinction,
      x: xOf(value),
      y: axis().to(extinction),
      fromX: event.clientX,
      fromY: event.clientY,
      box,
    };
    area.setPointerCapture(event.pointerId);
  }

  function drag(event) {
    const { n, merge, value, extinction, x, y, fromX, fromY } = dragged;
    const [dx, dy] = [event.clientX - fromX, event.clientY - fromY];
    // What was not moved along an axis stays exact there.
    const nextValue = Math.abs(dx) < 1 ? value : neat(valueAt(Math.min(width, Math.max(0, x + dx))));
    const nextExtinction =
      Math.abs(dy) < 1
        ? extinction
        : Number(
            axis()
              .from(y - dy / HEIGHT)
              .toPrecision(4),
          );
    put(moved(what.points, n, nextValue, nextExtinction), merge);
  }

  let nudged = null;
  function key(event, n) {
    const step = event.shiftKey ? FINE_PX : KEY_PX;
    const [dx, dy] = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key] ?? [
      0, 0,
    ];
    if (event.key === "Delete" || event.key === "Backspace") ondelete(n);
    else if (!dx && !dy) return;
    else {
      const [value, , extinction] = what.points[n];
      nudged = nudged?.n === n ? nudged : { n, merge: stroke("points") };
      const nextValue = dx
        ? rounded(
            value + (dx * (range[1] - range[0])) / width,
            10 ** Math.floor(Math.log10(((range[1] - range[0]) / width) * FINE_PX)),
          )
        : value;
      const next = dy
        ? Number(
            axis()
              .from(axis().to(extinction) + dy / HEIGHT)
              .toPrecision(6),
          )
        : extinction;
      put(moved(what.points, n, nextValue, next), nudged.merge);
    }
    event.preventDefault();
    event.stopPropagation();
  }

  function put(points, merge) {
    what = { ...what, points };
    redraw();
    onpoints(points, merge);
  }

  // -- pointer on the plot

  area.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !what) return;
    const [x, y] = at(event);
    if (isNear(x, y)) {
      const [points, n] = added(what.points, neat(valueAt(x)));
      what = { ...what, points };
      redraw();
      begin(event, n);
      onpoints(points, dragged.merge);
      focus();
    } else if (own) {
      dragged = { pan: range, fromX: event.clientX };
      area.setPointerCapture(event.pointerId);
    }
    event.preventDefault();
  });
  area.addEventListener("pointermove", (event) => {
    if (!what) return;
    const [x, y] = at(event);
    pointed = valueAt(Math.min(width, Math.max(0, x)));
    if (dragged?.pan) look(panned(dragged.pan, ((dragged.fromX - event.clientX) * (range[1] - range[0])) / width, farthest()));
    else if (dragged) drag(event);
    else area.classList.toggle("near", isNear(x, y));
    read();
  });
  const end = () => {
    if (!dragged) return;
    const { merge } = dragged;
    dragged = null;
    if (merge) onpoints(null, merge);
    if (what) redraw();
  };
  area.addEventListener("pointerup", end);
  area.addEventListener("pointercancel", end);
  area.addEventListener("pointerleave", () => {
    if (dragged) return;
    pointed = null;
    if (what) read();
  });
  area.addEventListener(
    "wheel",
    (event) => {
      if (!what) return;
      event.preventDefault();
      zoom(ZOOM ** (-event.deltaY / 100), valueAt(at(event)[0]));
    },
    { passive: false },
  );

  const at = (event) => {
    const box = area.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  /** Whether a place is on the curve, or on the upright of a step. */
  function isNear(x, y) {
    const height = axis();
    const tall = [-2, 0, 2].map((by) => HEIGHT * (1 - height.to(evaluate(what.points, valueAt(x + by)).extinction)));
    return y > Math.min(...tall) - NEAR_PX && y < Math.max(...tall) + NEAR_PX;
  }

  // -- the shown range

  function look(next) {
    range = next;
    own = true;
    redraw();
  }
  const zoom = (factor, about = valueAt(width / 2)) => look(zoomed(range, about, factor, farthest()));
  function fit() {
    own = false;
    range = whole();
    redraw();
  }

  function select(n) {
    selected = n;
    for (const target of handles.children) target.classList.toggle("chosen", Number(target.dataset.point) === n);
    read();
    onselect(n);
  }
  const focus = () => handles.querySelector(`[data-point="${selected}"]`)?.focus({ preventScroll: true });

  new ResizeObserver(redraw).observe(area);

  return {
    element,
    fit,
    zoom,
    focus,
    select,
    selected: () => selected,
    mark(value) {
      marked = value;
      redraw();
    },
    busy: () => Boolean(dragged),
    /** A value that the next point or peak may have: where the pointer was last, or the middle of what is shown. */
    middle: () => neat(valueAt(width / 2)),
    show(next, isOther) {
      const [first, last] = domain(next.points);
      const before = what;
      what = next;
      selected = Math.min(selected, next.points.length - 1);
      const moved_ = !before || before.limits[0] !== next.limits[0] || before.limits[1] !== next.limits[1];
      // The whole function is inside of what is shown, unless a user looks closer at a part of it.
      if (isOther || !range || moved_ || (!own && !dragged)) {
        own = own && !isOther && !moved_;
        if (!own) range = whole();
      } else if (!dragged && (first < range[0] || last > range[1]) && String(domain(before.points)) !== String([first, last]))
        fit();
      redraw();
    },
  };
}
