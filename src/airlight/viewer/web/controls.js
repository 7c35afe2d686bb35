// Controls that know their unit and range. Each is { element, show(value) }; show leaves alone what a user is at.
import { h, fill } from "./dom.js";

let count = 0;
const STEPS = 1000;
const QUIET_MS = 250;

/** Shows values by put, though not against the hand of a user: what comes while busy, or just after input, is shown later. */
export function patient(put, busy = () => false) {
  let timer = 0;
  let until = 0;
  const show = (value) => {
    clearTimeout(timer);
    const wait = busy() ? QUIET_MS : until - performance.now();
    if (wait > 0) timer = setTimeout(() => show(value), wait);
    else put(value);
  };
  return { show, said: () => (until = performance.now() + QUIET_MS) };
}

/** Whether a field has the focus and holds what has not been said yet. */
function draft(input) {
  let changed = false;
  input.addEventListener("input", () => (changed = true));
  input.addEventListener("change", () => (changed = false));
  return () => changed && input.matches(":focus");
}

/** A label above its control, with its meaning. */
export function labelled(text, control, help = "") {
  const inner = control.matches("input, select") ? control : control.querySelector("input, select") ?? control;
  const id = (inner.id ||= `airlight-control-${++count}`);
  return h("div", { class: "field", title: help }, h("label", { for: id }, text), control);
}

/** A number with its unit, and a slider where it has a range (or begins at one: then the slider grows with it). */
export function number(parameter, onchange) {
  const { name, unit, choices: _choices, kind, at_least, up_to, above, below } = parameter;
  const low = at_least ?? above;
  const high = up_to ?? below;
  const whole = kind === "int";
  const label = spoken(parameter);
  let top = high ?? Math.max(1, 4 * Math.abs(parameter.default ?? 0.25));
  const digits = (value) => (whole ? String(value) : String(Number(Number(value).toPrecision(5))));
  const said = (value) => {
    if (Number.isFinite(value)) onchange(whole ? Math.round(value) : value, name);
  };
  const typed = h("input", {
    type: "number", class: "number", step: whole ? 1 : "any", min: low, max: high, "aria-label": label,
    placeholder: parameter.optional ? "auto" : undefined,
    onchange: () => (typed.value === "" && parameter.optional ? onchange(null, name) : said(typed.valueAsNumber)),
  });
  const slider = low === undefined ? null : h("input", {
    type: "range", min: 0, max: STEPS, step: 1, "aria-label": label,
    oninput: () => {
      const value = low + ((top - low) * slider.valueAsNumber) / STEPS;
      const inside = above !== undefined && value <= above ? above + (top - above) / STEPS : below !== undefined && value >= below ? top - (top - low) / STEPS : value;
      typed.value = digits(inside);
      slider.setAttribute("aria-valuetext", `${typed.value} ${unit ?? ""}`);
      quiet.said();
      said(Number(typed.value));
    },
  });
  const typing = draft(typed);
  const quiet = patient((value) => {
    typed.value = value === null || value === undefined || value === "none" ? "" : digits(value);
    if (!slider || typeof value !== "number") return;
    if (high === undefined && value > top) top = 2 * value;
    slider.value = Math.round((STEPS * (value - low)) / (top - low || 1));
    slider.setAttribute("aria-valuetext", `${digits(value)} ${unit ?? ""}`);
  }, () => typing() || slider?.matches(":active"));
  return { element: h("span", { class: "numeric" }, slider, typed, unit ? h("span", { class: "unit" }, unit) : null), show: quiet.show };
}

/** One of several words. */
export function choice(options, label, onchange) {
  const select = h("select", { "aria-label": label, onchange: () => (quiet.said(), onchange(select.value)) });
  const quiet = patient((value) => (select.value = value));
  const put = (names) => fill(select, names.map((name) => h("option", { value: typeof name === "string" ? name : name[0] }, typeof name === "string" ? words(name) : name[1])));
  put(options);
  return { element: select, show: quiet.show, put };
}

/** Yes or no. */
export function toggle(label, onchange) {
  const box = h("input", { type: "checkbox", "aria-label": label, onchange: () => (quiet.said(), onchange(box.checked)) });
  const quiet = patient((value) => (box.checked = Boolean(value)));
  return { element: box, show: quiet.show };
}

/** A colour: linear numbers on the wire, sRGB on the screen. */
export function colour(label, onchange) {
  const input = h("input", { type: "color", "aria-label": label, oninput: () => (quiet.said(), onchange(linearOf(input.value))) });
  const quiet = patient((hex) => (input.value = hex));
  return { element: input, show: (rgb) => rgb && quiet.show(hexOf(rgb)) };
}

/** Several numbers side by side. */
export function vector(parameter, onchange, names = ["x", "y", "z", "w"]) {
  const inputs = Array.from({ length: Number(parameter.kind.slice(3)) || 3 }, (_, n) =>
    h("input", { type: "number", class: "number", step: "any", "aria-label": `${spoken(parameter)}, ${names[n]}`, onchange: () => said(n) }));
  // What is written is rounded; of what nobody wrote, all digits are kept.
  let whole = [];
  const said = (n) => {
    if (!Number.isFinite(inputs[n].valueAsNumber)) return show(whole);
    whole = inputs.map((input, m) => (m === n ? input.valueAsNumber : whole[m] ?? input.valueAsNumber));
    if (whole.every(Number.isFinite)) onchange(whole, parameter.name);
  };
  const typing = inputs.map(draft);
  const { show } = patient((value) => {
    whole = Array.isArray(value) ? value : [];
    inputs.forEach((input, n) => (input.value = Number.isFinite(whole[n]) ? rounded(whole[n]) : ""));
  }, () => typing.some((busy) => busy()));
  return { element: h("span", { class: "vector" }, inputs), show };
}

/** A word, or what is written as one: lists of numbers by JSON. */
function text(parameter, onchange) {
  const plain = parameter.kind === "text";
  const input = h("input", { type: "text", "aria-label": spoken(parameter), onchange: () => onchange(plain ? input.value : parsed(input.value), parameter.name) });
  const { show } = patient((value) => (input.value = typeof value === "string" ? value : JSON.stringify(value ?? null)), draft(input));
  return { element: input, show };
}

function parsed(words_) {
  try {
    return JSON.parse(words_);
  } catch {
    return words_;
  }
}

/** The control of a parameter of a stage, by its kind. */
export function control(parameter, onchange, view) {
  const { name, kind, choices } = parameter;
  const said = (value) => onchange(value, name);
  if (choices?.length) return choice(choices, spoken(parameter), said);
  if (kind === "bool") return toggle(spoken(parameter), said);
  if (kind === "float" || kind === "int") return number(parameter, onchange);
  if (kind.startsWith("vec")) return vector(parameter, onchange);
  if (kind.startsWith("stage:")) return stage(view, kind.slice(6), spoken(parameter), said);
  return text(parameter, onchange);
}

/** A stage of a slot: which one, and the parameters that it has; onchange gets the whole of it as plain data. */
export function stage(view, slot, label, onchange) {
  const known = view.schema.stages[slot];
  const help = h("p", { class: "help" });
  const inner = h("div", { class: "parameters" });
  const select = choice(Object.keys(known), label, (name) => onchange({ name }));
  let name = "";
  let value = {};
  let controls = [];
  const put = (changed, parameter) => onchange({ ...value, name, [parameter]: changed }, parameter);
  const show = (data) => {
    value = typeof data === "string" ? { name: data } : (data ?? { name: "" });
    select.show(value.name);
    if (value.name !== name) {
      name = value.name;
      help.textContent = known[name]?.help ?? "";
      const parameters = (known[name]?.parameters ?? []).filter((parameter) => parameter.kind !== "value");
      controls = parameters.map((parameter) => [parameter, control(parameter, put, view)]);
      fill(inner, controls.map(([parameter, made]) => labelled(words(parameter.name), made.element, parameter.help)));
    }
    for (const [parameter, made] of controls) made.show(value[parameter.name] ?? parameter.default);
  };
  return { element: h("div", { class: "stage-choice" }, select.element, help, inner), show };
}

/** A button. */
export function button(label, onclick, extra = {}) {
  return h("button", { type: "button", onclick, ...extra }, label);
}

/** A button that adds something to a list. */
export const adder = (name, onclick) => button(`+ ${name.toLowerCase()}`, onclick, { "aria-label": name, title: `Add: ${name.toLowerCase()}` });

// -- words and colours

/** A number in as many digits as fit a narrow field: five, and the whole part. */
export const rounded = (x) => Number(x.toPrecision(Math.max(5, Math.ceil(Math.log10(Math.abs(x) + 1)) + 2)));

/** A name as words. */
export const words = (name) => name.replaceAll("_", " ");
const spoken = (parameter) => words(parameter.name) + (parameter.unit ? ` in ${parameter.unit}` : "");

/** Linear numbers of "#rrggbb". */
export const linearOf = (hex) => [1, 3, 5].map((at) => {
  const s = parseInt(hex.slice(at, at + 2), 16) / 255;
  return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
});

/** "#rrggbb" of linear numbers. */
export const hexOf = (rgb) => "#" + rgb.map((c) => {
  const s = c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055;
  return Math.round(255 * Math.min(1, Math.max(0, s))).toString(16).padStart(2, "0");
}).join("");
