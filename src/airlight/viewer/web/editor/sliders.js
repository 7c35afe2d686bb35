// Sliders that tell which of their changes belong together: onchange(value, merge).
import { h } from "../dom.js";
import { said } from "./axes.js";
import { stroke } from "./steady.js";

const STEPS = 1000;

/** A slider and a number on a logarithmic scale, from 1/1000 to 1000; what is typed may be 0. */
export const logSlider = (given) =>
  slider({ ...given, low: -3, high: 3, to: (x) => 10 ** x, from: (value) => Math.log10(Math.max(value, 1e-3)), least: 0 });

/** A slider and a number between two ends that can be changed: { element, show(value, ends) }. */
export function slider({
  label,
  unit = "",
  low = 0,
  high = 1,
  to = (x) => x,
  from = (value) => value,
  least,
  onchange,
  round = (value) => Number(value.toPrecision(4)),
}) {
  let merge = stroke(label);
  let ends = [low, high];
  const range = h("input", {
    type: "range",
    min: 0,
    max: STEPS,
    step: 1,
    "aria-label": label,
    oninput: () => {
      const value = round(to(ends[0] + ((ends[1] - ends[0]) * range.valueAsNumber) / STEPS));
      typed.value = value;
      speak(value);
      onchange(value, merge);
    },
    onchange: () => (merge = stroke(label)),
  });
  const typed = h("input", {
    type: "number",
    class: "number",
    step: "any",
    min: least,
    "aria-label": `${label}${unit ? ` in ${unit}` : ""}, number`,
    onchange: () => Number.isFinite(typed.valueAsNumber) && onchange(typed.valueAsNumber, stroke(label)),
  });
  const speak = (value) => range.setAttribute("aria-valuetext", `${said(value)} ${unit}`.trim());
  const show = (value, given = ends) => {
    if (range.matches(":active")) return;
    ends = given;
    range.value = Math.round((STEPS * (from(value) - ends[0])) / (ends[1] - ends[0] || 1));
    speak(value);
    if (document.activeElement !== typed) typed.value = Number(value.toPrecision(6));
  };
  return { element: h("span", { class: "numeric" }, range, typed, unit ? h("span", { class: "unit" }, unit) : null), show };
}
