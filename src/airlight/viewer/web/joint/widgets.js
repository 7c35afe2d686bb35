// Widgets above the histogram: shapes that are dragged, pulled by handles, and moved by arrow keys.
import { h, fill } from "../dom.js";
import { hexOf } from "../controls.js";
import { bounds, core, handles, holds, outline, pulled, shifted, withoutCorner } from "./shapes.js";
import { SIDE, placing, written } from "./plot.js";

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
const STEP = 0.01;

/**
 * Draw and edit the shapes of a function. `edit` is { shapes(), axes(), chosen(), choose(n), put(n, shape, merge), remove(n) }.
 * show() draws them as they are now.
 */
export function attachWidgets(plot, edit) {
  let drawn = [];
  let held = null;

  const draw = (n) => {
    const fillable = h("path", { class: "joint-fill" });
    const inner = h("path", { class: "joint-core" });
    const stops = h("linearGradient", { id: `${plot.id}-${n}`, gradientUnits: "userSpaceOnUse" });
    const body = h(
      "g",
      { class: "joint-widget", role: "slider", tabindex: 0, "aria-roledescription": "widget", "aria-valuenow": "0" },
      stops,
      fillable,
      inner,
    );
    body.addEventListener("focus", () => edit.choose(n));
    body.addEventListener("keydown", (event) =>
      keyed(
        event,
        (by) => edit.put(n, shifted(edit.shapes()[n], edit.axes(), by), `joint.${n}.keys`),
        () => edit.remove(n),
      ),
    );
    return { body, fillable, inner, stops, handles: [], kind: "" };
  };

  const drawHandle = (n, name) => {
    const mark = h(
      "g",
      { class: "joint-handle", role: "slider", tabindex: 0, "aria-valuenow": "0" },
      h("circle", { class: "joint-reach" }),
      h("circle", { class: "joint-dot" }),
    );
    const shape = () => edit.shapes()[n];
    const own = () => handles(shape(), edit.axes()).find((handle) => handle.name === name);
    const pull = (by) =>
      edit.put(
        n,
        pulled(
          shape(),
          edit.axes(),
          name,
          own().at.map((x, m) => x + by[m]),
        ),
        `joint.${n}.${name}.keys`,
      );
    const cut = () => name.startsWith("vertex") && edit.put(n, withoutCorner(shape(), edit.axes(), Number(name.slice(7))));
    mark.addEventListener("keydown", (event) => keyed(event, pull, cut));
    mark.addEventListener("pointerdown", (event) => {
      event.stopPropagation();
      event.preventDefault();
      mark.focus({ preventScroll: true });
      const { to } = placing(edit.axes());
      const [x, y] = to(own().at);
      const [px, py] = plot.at(event);
      held = { n, name, pointer: event.pointerId, aside: [x - px, y - py], merge: `joint.drag.${Math.random()}` };
      plot.svg.setPointerCapture(event.pointerId);
    });
    return mark;
  };

  function keyed(event, move, remove) {
    if (event.key === "Delete" || event.key === "Backspace") remove();
    else if (event.key in ARROWS) {
      const { span } = placing(edit.axes());
      move(ARROWS[event.key].map((way, m) => way * (event.shiftKey ? 0.1 : 1) * STEP * span(m)));
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  plot.svg.addEventListener("pointerdown", (event) => {
    const { from } = placing(edit.axes());
    const start = plot.at(event);
    const point = from(start);
    // What is chosen keeps the pointer where several lie above each other.
    const shapes = edit.shapes();
    const chosen = edit.chosen();
    const n =
      shapes[chosen] && holds(shapes[chosen], edit.axes(), point)
        ? chosen
        : shapes.findLastIndex((shape) => holds(shape, edit.axes(), point));
    if (n < 0) return edit.choose(-1);
    event.preventDefault();
    edit.choose(n);
    drawn[n].body.focus({ preventScroll: true });
    held = { n, start: point, shape: shapes[n], pointer: event.pointerId, merge: `joint.drag.${Math.random()}` };
    plot.svg.setPointerCapture(event.pointerId);
  });
  plot.svg.addEventListener("pointermove", (event) => {
    if (!held || event.pointerId !== held.pointer) return;
    const { from } = placing(edit.axes());
    const [x, y] = plot.at(event);
    const shape = edit.shapes()[held.n];
    if (!shape) return (held = null);
    if (held.name)
      edit.put(held.n, pulled(shape, edit.axes(), held.name, from([x + held.aside[0], y + held.aside[1]])), held.merge);
    else
      edit.put(
        held.n,
        shifted(
          held.shape,
          edit.axes(),
          from([x, y]).map((c, m) => c - held.start[m]),
        ),
        held.merge,
      );
  });
  const end = () => (held = null);
  plot.svg.addEventListener("pointerup", end);
  plot.svg.addEventListener("pointercancel", end);

  const show = () => {
    const shapes = edit.shapes();
    if (drawn.length !== shapes.length) {
      drawn = shapes.map((_, n) => draw(n));
      fill(
        plot.layers.widgets,
        drawn.map((one) => one.body),
      );
      fill(plot.layers.handles);
    }
    const axes = edit.axes();
    const { to } = placing(axes);
    shapes.forEach((shape, n) => {
      const { body, fillable, inner, stops } = drawn[n];
      const path = (points) =>
        `M${points
          .map((p) =>
            to(p)
              .map((x) => x.toFixed(3))
              .join(" "),
          )
          .join("L")}Z`;
      fillable.setAttribute("d", path(outline(shape, axes)));
      const share = core(shape);
      inner.setAttribute("d", share === null ? "" : path(outline(shape, axes, share)));
      paint(shape, axes, stops, fillable);
      body.classList.toggle("joint-chosen", n === edit.chosen());
      body.setAttribute("aria-label", `${shape.kind} ${n + 1} of ${shapes.length}`);
      body.setAttribute("aria-valuetext", told(shape, axes));
    });
    showHandles(shapes, axes, to);
  };

  function showHandles(shapes, axes, to) {
    drawn.forEach((one, n) => {
      const wanted = n === edit.chosen() ? handles(shapes[n], axes) : [];
      const key = wanted.map((handle) => handle.name).join();
      if (one.key !== key) {
        one.key = key;
        one.handles.forEach((mark) => mark.remove());
        one.handles = wanted.map((handle) => drawHandle(n, handle.name));
        plot.layers.handles.append(...one.handles);
      }
      wanted.forEach((handle, m) => {
        const mark = one.handles[m];
        mark.setAttribute(
          "transform",
          `translate(${to(handle.at)
            .map((x) => x.toFixed(3))
            .join(" ")})`,
        );
        mark.classList.toggle("joint-turns", Boolean(handle.round));
        mark.setAttribute("aria-label", `${shapes[n].kind} ${n + 1}: ${handle.label}`);
        mark.setAttribute(
          "aria-valuetext",
          handle.round ? `${Math.round(((shapes[n].angle_rad ?? 0) * 180) / Math.PI)}°` : both(handle.at, axes),
        );
      });
    });
  }

  /** Fill a widget with its colour, or with its ramp where that runs along the plot. */
  function paint(shape, axes, stops, element) {
    const { ramp } = shape;
    element.style.fillOpacity = 0.4;
    if (!ramp || ramp.axis > 1) {
      const rgb = ramp ? ramp.points[0][1] : shape.colour;
      element.style.fill = hexOf(rgb);
      element.style.stroke = hexOf(rgb);
      return;
    }
    const { to } = placing(axes);
    const [low, high] = [ramp.points[0][0], ramp.points.at(-1)[0]];
    const ends = [low, high].map((at) => to(ramp.axis === 0 ? [at, axes[1].low] : [axes[0].low, at]));
    Object.entries({ x1: ends[0][0], y1: ends[0][1], x2: ends[1][0], y2: ends[1][1] }).forEach(([name, x]) =>
      stops.setAttribute(name, x),
    );
    fill(
      stops,
      ramp.points.map(([at, rgb]) => h("stop", { offset: (at - low) / (high - low), "stop-color": hexOf(rgb) })),
    );
    element.style.fill = `url(#${stops.id})`;
    element.style.stroke = hexOf(ramp.points[0][1]);
  }

  return { show };
}

const both = (point, axes) => point.map((x, n) => `${axes[n].label} ${written(x, axes[n].high - axes[n].low)}`).join(", ");

/** A shape in words, for readers. */
export function told(shape, axes) {
  const ends = bounds(shape, axes).map(([low, high], n) => {
    const [a, b] = [low, high].map((x) => written(x, axes[n].high - axes[n].low));
    return `${axes[n].label} ${a} to ${b}${axes[n].unit && !axes[n].label.includes(axes[n].unit) ? ` ${axes[n].unit}` : ""}`;
  });
  return `${ends.join(", ")}; extinction ${Number(shape.extinction.toPrecision(3))}`;
}

/** Marks of what lies round the pointer: dots as large as their weights, and a cross at the point itself. */
export function showMarks(layer, axes, found) {
  if (!found?.marks?.length) return fill(layer);
  const { to } = placing(axes);
  const most = Math.max(...found.weights);
  const dots = found.marks.map((mark, n) => {
    const [x, y] = to(mark);
    const part = Math.sqrt(found.weights[n] / most);
    return h("circle", {
      cx: x.toFixed(2),
      cy: y.toFixed(2),
      r: (0.5 + 1.2 * part).toFixed(2),
      opacity: (0.25 + 0.75 * part).toFixed(2),
    });
  });
  const [x, y] = to(found.at);
  const inside = x >= 0 && x <= SIDE && y >= 0 && y <= SIDE;
  const cross = inside && h("path", { d: `M${x - 4} ${y}H${x + 4}M${x} ${y - 4}V${y + 4}` });
  return fill(layer, dots, cross);
}
