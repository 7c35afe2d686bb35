// The stages of the layer's look: slots and parameters out of the schema, so that one from outside appears by itself.
import { h } from "../dom.js";
import { labelled, stage, words } from "../controls.js";
import { layersOf } from "../layers.js";

// Tone is beside exposure in "Display"; the function has a panel of its own.
const ELSEWHERE = new Set(["tone"]);

export const panel = {
  title: "Look",
  order: 30,
  build(view) {
    const layers = layersOf(view);
    const slots = Object.entries(view.schema.slots).filter(([name, slot]) => slot.look && !ELSEWHERE.has(name));
    const made = slots.map(([name, slot]) => {
      const control = stage(view, name, words(name), (value, parameter) => view.edit(layers.path("look", name), value, parameter && `look.${name}.${parameter}`));
      return { name, control, element: h("section", { class: "slot" }, labelled(words(name), control.element, slot.help)) };
    });
    const show = () => made.forEach(({ name, control }) => control.show(layers.layer()?.look[name]));
    view.on("state", show);
    layers.on(show);
    show();
    return h("div", {}, made.map((one) => one.element));
  },
};
