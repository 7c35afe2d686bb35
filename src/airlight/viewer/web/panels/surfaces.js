// Surfaces at values: those in the transfer function, any number, each with its colours.
import { h, fill } from "../dom.js";
import { adder, button, colour, labelled, number } from "../controls.js";
import { layersOf } from "../layers.js";

const OPACITY = { name: "opacity", kind: "float", at_least: 0, up_to: 1, default: 1 };

export const panel = {
  title: "Surfaces",
  order: 39,
  build(view) {
    const layers = layersOf(view);
    const path = (...keys) => layers.path("transfer", "surfaces", ...keys);
    const surfaces = () => layers.layer()?.transfer?.surfaces ?? [];
    const put = (n, changes, merge) => view.edit(path(n), { ...surfaces()[n], ...changes }, merge);
    const list = h("ol", { class: "list" });
    const none = h("p", { class: "help" }, "Surfaces are drawn at values of a function of one value.");
    const add = adder("Surface", () => {
      const [low, high] = layers.volume().robust_range;
      const value = { value: Number(((low + high) / 2).toPrecision(3)), colour: [1, 1, 1], opacity: 1 };
      view.ops(surfaces().length ? [{ op: "insert", path: path(surfaces().length), value }] : [{ op: "set", path: path(), value: [value] }]);
    });
    let rows = [];
    let told = "";
    const show = () => {
      const plain = Boolean(layers.layer()?.transfer?.points);
      add.hidden = !plain;
      none.hidden = plain;
      const found = plain ? surfaces() : [];
      const now = `${layers.index()} ${found.length}`;
      if (now !== told) {
        told = now;
        rows = found.map((_, n) => rowOf(view, layers, n, put, () => view.ops([{ op: "remove", path: path(n) }])));
        fill(list, rows.map((row) => row.element));
      }
      rows.forEach((row, n) => row.show(found[n]));
    };
    view.on("state", show);
    layers.on(show);
    show();
    return h("div", {}, h("div", { class: "row" }, add), none, list);
  },
};

function rowOf(view, layers, n, put, remove) {
  const [low, high] = layers.volume().range;
  const unit = layers.volume().value_unit;
  const value = number({ name: "value", kind: "float", at_least: low, up_to: high, unit, default: low }, (x) => put(n, { value: x }, `surface.${n}.value`));
  const front = colour(`front of surface ${n + 1}`, (rgb) => put(n, { colour: rgb }, `surface.${n}.colour`));
  const back = colour(`back of surface ${n + 1}`, (rgb) => put(n, { back_colour: rgb }, `surface.${n}.back_colour`));
  const opacity = number(OPACITY, (x) => put(n, { opacity: x }, `surface.${n}.opacity`));
  const element = h("li", {},
    h("div", { class: "row" }, h("strong", {}, `${n + 1}.`), front.element, back.element, button("Remove", remove, { "aria-label": `remove surface ${n + 1}` })),
    labelled("value", value.element), labelled("opacity", opacity.element));
  const show = (data) => {
    value.show(data.value);
    front.show(data.colour);
    back.show(data.back_colour ?? data.colour);
    opacity.show(data.opacity);
  };
  return { element, show };
}
