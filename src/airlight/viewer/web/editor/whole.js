// The function as a whole: density of its layer, window and level, colours of a named map.
import { h, fill } from "../dom.js";
import { button, labelled } from "../controls.js";
import { domain, windowed } from "./points.js";
import { logSlider, slider } from "./sliders.js";

const MAPS = "airlight-colour-maps";

/** Controls of the whole function: { element, show() }. */
export function wholeControls({ view, edited, redraw }) {
  const { layers } = edited;
  const density = logSlider({
    label: "density",
    onchange: (value, merge) => edited.putBeside(layers.path("density"), value, merge),
  });
  const move = (at, width, merge) => {
    const [low, high] = domain(edited.transfer().points);
    edited.put(windowed(edited.transfer(), at ?? (low + high) / 2, width ?? high - low), merge);
    redraw();
  };
  const centre = slider({ label: "window centre", onchange: (value, merge) => move(value, null, merge) });
  const width = slider({
    label: "window width",
    least: 0,
    to: (x) => 10 ** x,
    from: (value) => Math.log10(Math.max(value, 1e-12)),
    onchange: (value, merge) => move(null, value, merge),
  });

  const maps = h("datalist", { id: MAPS });
  const swatch = h("div", { class: "tf-swatch", "aria-hidden": "true" });
  async function list() {
    if (maps.childElementCount) return;
    const { names } = await view.ask("transfer.colormaps");
    const all = Object.values(names).flat();
    fill(
      maps,
      all.map((name) => h("option", { value: name })),
    );
  }
  async function preview() {
    const found = await view.ask("transfer.swatch", { name: map.value }).catch(() => null);
    swatch.style.background = found ? `linear-gradient(to right, ${found.colours.join(", ")})` : "";
  }
  const map = h("input", {
    type: "text",
    list: MAPS,
    placeholder: "viridis, inferno, ...",
    "aria-label": "colour map",
    autocomplete: "off",
    spellcheck: "false",
    onfocus: () => list().catch(edited.fail),
    oninput: preview,
    onchange: () => map.value && edited.made("transfer.colormap", { name: map.value }),
  });

  const element = h(
    "div",
    {},
    labelled("density of the layer", density.element),
    labelled("window centre", centre.element),
    labelled("window width", width.element),
    labelled("colour map", map),
    swatch,
    maps,
    h(
      "div",
      { class: "line" },
      button("Reverse colours", () => edited.made("transfer.reversed")),
    ),
  );

  function show() {
    density.show(layers.layer().density ?? 1);
    const [low, high] = domain(edited.transfer().points);
    const [first, last] = edited.volume().robust_range;
    const span = last - first || 1;
    centre.show((low + high) / 2, [Math.min(first, low), Math.max(last, high)]);
    width.show(high - low, [Math.log10(span / 1000), Math.log10(Math.max(span * 4, high - low))]);
  }
  return { element, show };
}
