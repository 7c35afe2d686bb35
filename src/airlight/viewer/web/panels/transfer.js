// The transfer function of one value: its curve over the histogram, and all that changes it.
import { h } from "../dom.js";
import { button, choice, labelled } from "../controls.js";
import { layerPicker, layersOf } from "../layers.js";
import { roundUp } from "../editor/axes.js";
import { editedOf } from "../editor/edited.js";
import { pointFields } from "../editor/fields.js";
import { fileButtons } from "../editor/files.js";
import { makePlot } from "../editor/plot.js";
import { added, removed } from "../editor/points.js";
import { presetGrid } from "../editor/presets.js";
import { asked } from "../editor/target.js";
import { wholeControls } from "../editor/whole.js";

const ZOOM = 0.7;

export const panel = { title: "Transfer function", order: 10, build };

function build(view) {
  const layers = layersOf(view);
  const shown = { quantity: "extinction", scale: "power", log: true, length: 0 };
  let histogram = null;
  let counted = "";
  let top = 1;
  let picked = null; // where in the picture the pointer was last

  const edited = editedOf(view, { changed: () => show(), isBusy: () => plot.busy() });
  const points = () => edited.transfer().points;

  // -- points

  const plot = makePlot({
    onpoints(next, merge) {
      if (next) edited.putPoints(next, merge);
      else edited.flush();
      if (next) showParts();
      else show();
    },
    onselect: () => showParts(),
    ondelete: (n) => remove(n),
  });
  const chosen = () => Math.min(plot.selected(), points().length - 1);

  function choose(n) {
    show();
    plot.select(n);
    plot.focus();
  }
  function remove(n = chosen()) {
    if (points().length < 2) return;
    edited.putPoints(removed(points(), n));
    choose(Math.min(n, points().length - 1));
  }
  /** A point in the wider gap beside the chosen one. */
  function add() {
    const [before, here, after] = [-1, 0, 1].map((by) => points()[chosen() + by]?.[0]);
    const gaps = [
      [here, after],
      [before, here],
    ].filter(([low, high]) => high > low);
    const [gap] = gaps.sort((a, b) => b[1] - b[0] - (a[1] - a[0]));
    const [next, n] = added(points(), gap ? Number(((gap[0] + gap[1]) / 2).toPrecision(6)) : plot.middle());
    edited.putPoints(next);
    choose(n);
  }

  // -- what was pointed at in the picture

  function probed(found) {
    const { layer, part } = edited.target();
    if (!found.hit || found.layer !== layer) return;
    const channel = part === null ? null : layers.parts()[part].channel;
    const name = typeof channel === "number" ? `channel ${channel}` : channel;
    const value = found.values[channel === null ? 0 : Math.max(0, found.names.indexOf(name))];
    if (typeof value !== "number") return;
    picked = found.p_world;
    plot.mark(value);
  }
  const peak = () => edited.made("transfer.peak", picked ? { p_world: picked } : { value: points()[chosen()][0] });

  // -- controls

  const pick = (name, words, label) =>
    choice(
      words.map((word) => [word, word]),
      label,
      (value) => {
        shown[name] = name === "log" ? value === "log" : value;
        show();
      },
    );
  const quantity = pick("quantity", ["extinction", "opacity"], "height of the curve");
  const scale = pick("scale", ["linear", "power", "log"], "scale of the heights");
  const bars = pick("log", ["log", "linear"], "scale of the histogram");

  const fields = pointFields({ edited, chosen, shown, redraw: () => show() });
  const whole = wholeControls({ view, edited, redraw: () => show() });
  const presets = presetGrid(view, edited.take);
  const notes = h("p", { class: "help", role: "status" });
  const tool = (label, name, onclick) => button(label, onclick, { "aria-label": name, title: name.toLowerCase() });
  const less = tool("− point", "Remove the chosen point", () => remove());
  const automatic = () => edited.made("presets.function", { name: "automatic" });
  const boundaries = () => edited.made("presets.function", { name: "boundaries" });

  const body = h(
    "div",
    {},
    h(
      "div",
      { class: "line tf-tools" },
      tool("+ point", "Add a point", add),
      less,
      h("span", { class: "grow" }),
      h("span", { class: "help" }, "zoom"),
      tool("−", "Show more values", () => plot.zoom(1 / ZOOM)),
      tool("+", "Show fewer values", () => plot.zoom(ZOOM)),
      tool("fit", "Show the whole function", () => plot.fit()),
    ),
    plot.element,
    h(
      "div",
      { class: "tf-grid three" },
      labelled("height", quantity.element),
      labelled("scale", scale.element),
      labelled("histogram", bars.element),
    ),
    fields.element,
    whole.element,
    h(
      "div",
      { class: "line" },
      button("Automatic", automatic, { title: "the function of the first picture" }),
      button("Boundaries", boundaries, { title: "boundaries between materials, found in the data" }),
      button("Peak here", peak, { title: "a peak at what was last pointed at in the picture, or at the chosen point" }),
    ),
    h("h3", {}, "Presets"),
    presets.element,
    fileButtons({ view, edited }),
    notes,
  );
  const other = h(
    "p",
    { class: "help" },
    "This layer has a function of several variables. ",
    button("Take one of the value", automatic),
  );

  // -- what is shown

  function count() {
    const { key } = edited.target();
    if (key === counted) return;
    counted = key;
    histogram = null;
    const taken = (found) => {
      if (key !== counted) return;
      histogram = found;
      show();
    };
    view.ask("histogram", asked(edited.target())).then(taken, edited.fail);
  }

  function show(isAnother = false) {
    const isOther = edited.refresh(isAnother);
    const { transfer } = edited.target();
    body.hidden = !transfer;
    other.hidden = Boolean(transfer);
    if (!transfer || !edited.volume()) return;
    count();
    showPlot(isOther);
    quantity.show(shown.quantity);
    scale.show(shown.scale);
    bars.show(shown.log ? "log" : "linear");
    presets.show();
    showParts();
  }

  function showPlot(isOther) {
    const volume = edited.volume();
    const { surfaces = [], associated } = edited.transfer();
    shown.length ||= Number(Math.min(...volume.spacing).toPrecision(3));
    const most = Math.max(...points().map((point) => point[2]));
    if (!plot.busy() && (most > top || most < top / 3)) top = most > 0 ? roundUp(most * 1.05) : 1 / shown.length;
    const given = {
      points: points(),
      histogram,
      limits: histogram ? [histogram.low, histogram.high] : volume.robust_range,
      dataRange: volume.range,
      top,
      ...shown,
      unit: volume.value_unit ?? "",
      lengthUnit: edited.lengthUnit(),
      marks: surfaces.map(({ value }) => ({ value, dashed: true })),
    };
    plot.show(given, isOther);
    const told = [
      associated ? "Associated: colours are light that is given off, whatever the extinction." : "",
      surfaces.length ? `${surfaces.length} of its surfaces of equal value are dashed.` : "",
      histogram?.outside ? `${histogram.outside.toLocaleString("en")} samples lie beyond the histogram.` : "",
    ];
    notes.textContent = told.filter(Boolean).join(" ");
  }

  function showParts() {
    if (!edited.transfer()) return;
    fields.show();
    whole.show();
    less.disabled = points().length < 2;
  }

  view.on("state", () => plot.busy() || show());
  view.on("error", edited.settle);
  view.on("probed", (found) => edited.target().transfer && probed(found));
  layers.on(() => {
    picked = null;
    shown.length = 0;
    plot.mark(null);
    show(true);
  });
  show();
  return h("div", { class: "transfer" }, layerPicker(view), other, body);
}
