// The chosen point as numbers and a colour: opacity is over a length that is told.
import { h } from "../dom.js";
import { labelled } from "../controls.js";
import { extinctionOf, opacityOf } from "./axes.js";
import { MOST_GLOW, joined, split } from "./colors.js";
import { moved, recoloured } from "./points.js";
import { stroke } from "./steady.js";

/** Fields of the chosen point: { element, show() }; `shown.length` is the length, `redraw` shows all again. */
export function pointFields({ edited, chosen, shown, redraw }) {
  const numeric = (label, onvalue, more = {}) => {
    const onchange = () => Number.isFinite(input.valueAsNumber) && (onvalue(input.valueAsNumber), redraw());
    const input = h("input", { type: "number", class: "number", step: "any", "aria-label": label, onchange, ...more });
    return input;
  };
  const point = () => edited.transfer().points[chosen()];
  const change = (value, extinction) => edited.putPoints(moved(edited.transfer().points, chosen(), value, extinction));

  const value = numeric("value of the point", (next) => change(next, point()[2]));
  const extinction = numeric("extinction of the point", (next) => change(point()[0], next));
  const opacity = numeric("opacity of the point in percent", (next) =>
    change(point()[0], extinctionOf(next / 100, shown.length)),
  );
  const length = numeric("length over which opacities are told", (next) => next > 0 && (shown.length = next));

  let merge = stroke("colour");
  const paint = () => {
    const light = Math.min(MOST_GLOW, Math.max(1, glow.valueAsNumber || 1));
    edited.putPoints(recoloured(edited.transfer().points, chosen(), joined(colour.value, light, point()[1])), merge);
    redraw();
  };
  const endPaint = () => (merge = stroke("colour"));
  const colour = h("input", { type: "color", "aria-label": "colour of the point", oninput: paint, onchange: endPaint });
  const glow = numeric("glow of the point, 1 to 16", paint, { min: 1, max: MOST_GLOW });

  const units = [0, 1, 2].map(() => h("span", { class: "unit" }));
  const field = (label, input, unit) => labelled(label, h("span", { class: "numeric" }, input, unit));
  const element = h(
    "div",
    { class: "tf-grid two" },
    field("value", value, units[0]),
    field("extinction", extinction, units[1]),
    field("opacity", opacity, h("span", { class: "unit" }, "%")),
    field("over a length of", length, units[2]),
    field("colour", colour),
    field("glow", glow),
  );
  const put = (input, number) => document.activeElement !== input && (input.value = Number(number.toPrecision(6)));

  function show() {
    const [at, rgb, strength] = point();
    put(value, at);
    put(extinction, strength);
    put(opacity, 100 * opacityOf(strength, shown.length));
    put(length, shown.length);
    const { hex, glow: light } = split(rgb);
    if (colour.value !== hex) colour.value = hex;
    put(glow, light);
    units[0].textContent = edited.volume().value_unit ?? "";
    units[1].textContent = `per ${edited.lengthUnit()}`;
    units[2].textContent = edited.lengthUnit();
  }
  return { element, show };
}
