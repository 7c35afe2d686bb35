// From radiance to the screen: tone and exposure, and what lies behind the picture.
import { h } from "../dom.js";
import { choice, colour, labelled, stage } from "../controls.js";

export const panel = {
  title: "Display",
  order: 60,
  build(view) {
    // One tone maps the whole picture: that of the first layer.
    const tone = stage(view, "tone", "tone", (value, parameter) => view.ops(
      view.document().scene.layers.map((_, n) => ({ op: "set", path: ["scene", "layers", n, "look", "tone"], value })), parameter && `tone.${parameter}`));
    const kind = choice([["colour", "a colour"], ["none", "transparent"], ["environment", "the surroundings"]], "background", (value) => {
      const next = { colour: [0, 0, 0], none: "none", environment: { kind: "studio" } }[value];
      view.edit(["scene", "background"], next);
    });
    const plain = colour("colour of the background", (rgb) => view.edit(["scene", "background"], rgb, "background"));
    const tint = labelled("its colour", plain.element);
    const show = () => {
      const { layers, background } = view.document().scene;
      if (layers.length) tone.show(layers[0].look.tone);
      const isColour = Array.isArray(background) || (typeof background === "string" && background !== "none");
      kind.show(isColour ? "colour" : background === "none" ? "none" : "environment");
      tint.hidden = !Array.isArray(background);
      if (Array.isArray(background)) plain.show(background);
    };
    view.on("state", show);
    show();
    return h("div", {}, labelled("tone", tone.element), labelled("background", kind.element), tint);
  },
};
