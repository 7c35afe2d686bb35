// What of the chosen widget is set by controls: colour or ramp, extinction, fall-off, interval along the third axis.
import { h, fill } from "../dom.js";
import { button, choice, colour, labelled, number } from "../controls.js";
import { logSlider, slider } from "../editor/sliders.js";
import { stroke } from "../editor/steady.js";
import { bounds, thirdOf, withCorner, withThird } from "./shapes.js";
import { SIDE, written } from "./plot.js";

/** { element, show(shape, axes, details) } of the widget that `put(shape, merge)` changes. */
export function makeFields(put) {
  let shape = null;
  let axes = null;
  const change = (changes, merge) => put({ ...shape, ...changes }, merge);

  const extinction = logSlider({
    label: "extinction of the widget",
    onchange: (value, merge) => change({ extinction: value }, merge),
  });
  const seen = h("p", { class: "help" });
  const edge = slider({
    label: "fall-off to the border",
    onchange: (value, merge) => change({ edge: Math.min(1, Math.max(0, value)) }, merge),
  });
  const edgeField = labelled(
    "fall-off",
    edge.element,
    "Share of the half width over which the weight falls to 0 at the border",
  );
  const angle = number({ name: "turn", kind: "float", unit: "°" }, (value) =>
    change({ angle_rad: (value * Math.PI) / 180 }, stroke("turn")),
  );
  const angleField = labelled("turn", angle.element);
  const along = choice([["", "one colour"]], "colours of the widget", (value) => setRamp(value));
  const one = strokedColour("colour of the widget", (rgb, merge) => change({ colour: rgb }, merge));
  const ramp = h("div", { class: "joint-ramp" });
  const corner = button("Add a corner", () => put(withCorner(shape, axes)));
  const third = makeThird((ends, merge) => put(withThird(shape, axes, ends), merge));
  const element = h(
    "div",
    { class: "joint-fields", hidden: true },
    labelled("colour", h("span", { class: "row" }, one.element, along.element)),
    ramp,
    labelled("extinction", extinction.element, "Per world unit of length, where the weight is 1"),
    seen,
    edgeField,
    angleField,
    third.element,
    corner,
  );
  let points = [];

  function setRamp(axis) {
    if (axis === "") return put({ ...shape, colour: shape.ramp?.points[0][1] ?? shape.colour, ramp: undefined });
    const n = Number(axis);
    const [low, high] = n === 2 ? thirdOf(shape, axes) : bounds(shape, axes)[n];
    const colours = shape.ramp?.points.map(([, rgb]) => rgb) ?? [shape.colour, [1, 1, 1]];
    put({
      ...shape,
      ramp: { axis: n, points: colours.map((rgb, m) => [low + ((high - low) * m) / (colours.length - 1), rgb]) },
    });
  }

  const setPoints = (changed, merge) =>
    change({ ramp: { ...shape.ramp, points: [...changed].sort((a, b) => a[0] - b[0]) } }, merge);
  function showRamp() {
    const found = shape.ramp?.points ?? [];
    ramp.hidden = !found.length;
    if (points.length !== found.length) {
      points = found.map((_, n) => {
        const at = number({ name: `colour ${n + 1} at`, kind: "float" }, (value) => {
          const others = shape.ramp.points;
          if (!others.some(([x], m) => m !== n && x === value)) setPoints(others.map((p, m) => (m === n ? [value, p[1]] : p)));
        });
        const rgb = strokedColour(`colour ${n + 1} of the ramp`, (value, merge) =>
          setPoints(
            shape.ramp.points.map((p, m) => (m === n ? [p[0], value] : p)),
            merge,
          ),
        );
        const drop = button("×", () => setPoints(shape.ramp.points.filter((_, m) => m !== n)), {
          class: "small",
          "aria-label": `Remove colour ${n + 1}`,
        });
        return { at, rgb, drop, element: h("div", { class: "row" }, rgb.element, at.element, drop) };
      });
      const add = button("Add a colour", () => {
        const all = shape.ramp.points;
        const [a, b] = all.slice(-2);
        setPoints([...all.slice(0, -1), [(a[0] + b[0]) / 2, a[1].map((c, m) => (c + b[1][m]) / 2)], b]);
      });
      fill(
        ramp,
        points.map((point) => point.element),
        add,
      );
    }
    points.forEach((point, n) => {
      point.at.show(found[n][0]);
      point.rgb.show(found[n][1]);
      point.drop.disabled = found.length < 3;
    });
  }

  const show = (given, its, details) => {
    element.hidden = !given;
    if (!given) return;
    shape = given;
    axes = its;
    one.element.hidden = Boolean(shape.ramp);
    one.show(shape.colour);
    along.put([
      ["", "one colour"],
      ...axes.map((_, n) => [String(n), `ramp along ${details.axes[n]?.label ?? axes[n].variable}`]),
    ]);
    along.show(shape.ramp ? String(shape.ramp.axis) : "");
    showRamp();
    extinction.show(shape.extinction);
    const voxel = details.voxel;
    const percent = (-100 * Math.expm1(-shape.extinction * voxel)).toFixed(voxel * shape.extinction < 0.01 ? 2 : 0);
    seen.textContent = `per ${details.units || "unit"}: ${percent} % opaque in a voxel, where the weight is 1`;
    edgeField.hidden = shape.kind === "ellipse";
    edge.show(shape.edge ?? (shape.kind === "triangle" ? 1 : 0));
    angleField.hidden = shape.kind !== "ellipse";
    angle.show(Math.round((1800 * (shape.angle_rad ?? 0)) / Math.PI) / 10);
    corner.hidden = shape.kind !== "polygon";
    third.show(axes.length === 3 ? thirdOf(shape, axes) : null, details.axes[2], details.third);
  };
  return { element, show };
}

/** A colour whose changes are one step of undo until its picker is closed. */
function strokedColour(label, onchange) {
  let merge = stroke("colour");
  const made = colour(label, (rgb) => onchange(rgb, merge));
  made.element.addEventListener("change", () => (merge = stroke("colour")));
  return made;
}

/** Two ends on the third axis, with what of the volume lies along it behind them. */
function makeThird(onchange) {
  const path = h("path", { class: "joint-third-counts" });
  const chosen = h("rect", { class: "joint-third-chosen", y: 0, height: 20 });
  const svg = h(
    "svg",
    { class: "joint-third", viewBox: `0 0 ${SIDE} 20`, preserveAspectRatio: "none", "aria-hidden": "true" },
    path,
    chosen,
  );
  let ends = [0, 1];
  const change = (n) => (value, merge) =>
    onchange(
      ends.map((old, m) => (m === n ? value : old)),
      merge,
    );
  const sliders = ["from", "to"].map((word, n) => slider({ label: `third axis, ${word}`, onchange: change(n) }));
  const name = h("p", { class: "help" });
  const element = h("div", {}, name, svg, labelled("from", sliders[0].element), labelled("to", sliders[1].element));
  const show = (given, axis, counts) => {
    element.hidden = !given || !axis;
    if (element.hidden) return;
    ends = given;
    name.textContent = `${axis.label}: ${given.map((x) => written(x, axis.high - axis.low)).join(" to ")}`;
    sliders.forEach((one, n) => one.show(given[n], [axis.low, axis.high]));
    if (counts) {
      const line = counts.map(
        (shade, n) => `L${((SIDE * n) / (counts.length - 1)).toFixed(2)} ${(20 - shade / 12.75).toFixed(2)}`,
      );
      path.setAttribute("d", `M0 20${line.join("")}L${SIDE} 20Z`);
    }
    const [a, b] = given.map((x) => (SIDE * (x - axis.low)) / (axis.high - axis.low));
    chosen.setAttribute("x", a);
    chosen.setAttribute("width", b - a);
  };
  return { element, show };
}
