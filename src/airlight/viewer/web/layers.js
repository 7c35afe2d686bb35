// The layer, and of a mixture the channel, that the panels edit: one choice for a view, kept beside it.
import { h, fill } from "./dom.js";
import { button, choice, labelled } from "./controls.js";
import { logSlider } from "./editor/sliders.js";

const known = new WeakMap();

/** The choice of a view: { all(), layer(), index(), path(...keys), volume(), parts(), part(), choose(n), choosePart(n), on() }. */
export function layersOf(view) {
  if (!known.has(view)) known.set(view, made(view));
  return known.get(view);
}

function made(view) {
  const listeners = new Set();
  let chosen = 0;
  let part = 0;
  const all = () => view.document()?.scene.layers ?? [];
  const index = () => Math.max(0, Math.min(chosen, all().length - 1));
  const layer = () => all()[index()];
  const parts = () => layer()?.transfer?.channels ?? null;
  const tell = () => listeners.forEach((listener) => listener());
  return {
    all,
    index,
    layer,
    parts,
    volumeOf: (one) => view.volumes[idOf(one?.volume)],
    volume: () => view.volumes[idOf(layer()?.volume)],
    path: (...keys) => ["scene", "layers", index(), ...keys],
    /** Number of the part of a mixture that is edited; null without a mixture. */
    part: () => (parts() ? Math.max(0, Math.min(part, parts().length - 1)) : null),
    choose: (n) => ((chosen = n), (part = 0), tell()),
    choosePart: (n) => ((part = n), tell()),
    on: (listener) => (listeners.add(listener), () => listeners.delete(listener)),
  };
}

const idOf = (volume) => (typeof volume === "string" ? volume : volume?.file);

/** What a layer is called. */
export function layerName(view, layer, n) {
  const name = view.volumes[idOf(layer.volume)]?.name;
  return name ? `${n + 1}: ${name}` : `layer ${n + 1}`;
}

/** A select of the layer that is edited; not shown where there is one alone. */
export function layerPicker(view) {
  const layers = layersOf(view);
  let told = "";
  const select = choice([], "layer", (value) => layers.choose(Number(value)));
  const element = labelled("layer", select.element);
  const show = () => {
    const names = layers.all().map((layer, n) => [String(n), layerName(view, layer, n)]);
    element.hidden = names.length < 2;
    if (JSON.stringify(names) !== told) select.put(names);
    told = JSON.stringify(names);
    select.show(String(layers.index()));
  };
  view.on("state", show);
  layers.on(show);
  show();
  return element;
}

/** All layers with what is drawn of them. */
export function layerList(view) {
  const layers = layersOf(view);
  const list = h("ul", { class: "list", "aria-label": "Layers" });
  const volumes = choice([], "volume of the new layer", () => {});
  let told = "";
  let rows = [];

  const row = (n) => {
    const seen = h("input", { type: "checkbox", onchange: () => view.edit(["scene", "layers", n, "visible"], seen.checked) });
    const name = h("button", { type: "button", class: "row-name", onclick: () => layers.choose(n) });
    const density = logSlider({
      label: `density of layer ${n + 1}`,
      onchange: (value, merge) => view.edit(["scene", "layers", n, "density"], value, merge),
    });
    const copy = button("Copy", () => view.ops([{ op: "insert", path: ["scene", "layers", n + 1], value: layers.all()[n] }]), {
      "aria-label": `Copy layer ${n + 1}`,
    });
    const remove = button("×", () => view.ops([{ op: "remove", path: ["scene", "layers", n] }]), {
      class: "small",
      "aria-label": `Remove layer ${n + 1}`,
      title: "remove",
    });
    const show = () => {
      const layer = layers.all()[n];
      const words = layerName(view, layer, n);
      seen.checked = layer.visible ?? true;
      seen.setAttribute("aria-label", `show ${words}`);
      name.textContent = words;
      name.setAttribute("aria-pressed", String(layers.index() === n));
      density.show(layer.density ?? 1);
      remove.disabled = layers.all().length < 2;
    };
    return {
      element: h("li", {}, h("div", { class: "line" }, seen, name, copy, remove), labelled("density", density.element)),
      show,
    };
  };
  const show = () => {
    if (rows.length !== layers.all().length) {
      rows = layers.all().map((_, n) => row(n));
      fill(
        list,
        rows.map((made_) => made_.element),
      );
    }
    rows.forEach((made_) => made_.show());
    const names = Object.entries(view.volumes).map(([id, volume]) => [id, volume.name || id]);
    if (JSON.stringify(names) !== told) volumes.put(names);
    told = JSON.stringify(names);
  };
  const add = button("Add layer", () => {
    const end = layers.all().length;
    view.ops([{ op: "insert", path: ["scene", "layers", end], value: { volume: volumes.element.value } }]);
    layers.choose(end);
  });
  view.on("state", show);
  layers.on(show);
  show();
  return h("div", {}, list, h("div", { class: "line" }, volumes.element, add));
}
