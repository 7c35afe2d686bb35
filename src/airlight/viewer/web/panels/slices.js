// The layout of the view, and what slices show.
import { h, fill } from "../dom.js";
import { button, choice, labelled, toggle } from "../controls.js";
import { slider } from "../editor/sliders.js";
import { handle } from "../handles.js";
import { layersOf } from "../layers.js";
import { slicesOf } from "../slices.js";
import { placeText } from "../seen.js";
import { basis } from "../view.js";
import { length, minus, onSphere, plus, unit } from "../vectors.js";

const LAYOUTS = [
  ["volume", "Volume"],
  ["both", "Volume and slices"],
  ["slices", "Slices"],
];
const HANDS = [
  ["cross", "moves the cross-hair"],
  ["window", "changes black and white"],
  ["pan", "moves the slice"],
  ["zoom", "zooms"],
];

export const panel = {
  title: "Slices",
  icon: "slices",
  order: 37,
  build(view) {
    const slices = slicesOf(view);
    const layers = layersOf(view);
    const buttons = LAYOUTS.map(([name, word]) =>
      h("button", { type: "button", role: "radio", onclick: () => slices.show(name) }, word),
    );
    const group = h("div", { class: "row", role: "radiogroup", "aria-label": "Layout" }, buttons);
    const hand = choice(HANDS, "what a drag in a slice does", (value) => (slices.options.hand = value));
    const black = slider({
      label: "black",
      onchange: (value) => slices.setWindow([Math.min(value, slices.window()[1] - 1e-6 * span()), slices.window()[1]]),
    });
    const white = slider({
      label: "white",
      onchange: (value) => slices.setWindow([slices.window()[0], Math.max(value, slices.window()[0] + 1e-6 * span())]),
    });
    const range = () => layers.volume()?.range ?? [0, 1];
    const span = () => range()[1] - range()[0] || 1;
    const usual = button("Automatic", () => slices.useUsualWindow());
    const labels = slider({
      label: "regions",
      onchange: (value) => ((slices.options.labels = Math.min(1, Math.max(0, value))), slices.draw()),
    });
    labels.show(slices.options.labels);
    const clip = toggle("the volume is cut at the cross-hair", (value) => slices.setClip(value));
    const facing = toggle("the oblique slice faces the eye", (value) => {
      slices.setFacing(value);
      showHandle();
    });
    facing.show(true);
    const where = h("p", { class: "help" });
    const rest = h(
      "div",
      {},
      where,
      labelled("a drag", hand.element),
      labelled("black", black.element),
      labelled("white", white.element),
      h("div", { class: "row" }, usual),
      labelled("regions", labels.element, "How strongly the colours of labels lie over the slices"),
      labelled("cut away", clip.element, "The corner of the volume towards the eye, at the cross-hair"),
      labelled("faces the eye", facing.element, "The oblique slice; else its handle in the volume turns it"),
    );

    // The free oblique slice: a handle at the end of its normal.
    const above = h("g", { class: "slice-normal" });
    view.overlay.append(above);
    const reach = () => 0.25 * length(minus(layers.volume().high_world, layers.volume().low_world));
    const turn = handle(view, {
      label: "oblique slice: direction",
      shape: "square",
      at: () => plus(slices.point(), slices.normal(), reach()),
      dragged: (ray) => slices.setNormal(minus(onSphere(slices.point(), reach(), ray), slices.point())),
      stepped: (by) => slices.setNormal(unit(plus(slices.normal(), basis(view.frame().camera).right, 0.05 * by))),
      told: () =>
        slices
          .normal()
          .map((x) => x.toFixed(2))
          .join(", "),
    });
    const free = () => !slices.options.facing && slices.layout() !== "slices";
    const showHandle = () => {
      if (free() !== Boolean(above.childElementCount)) fill(above, free() ? turn.element : null);
      if (free() && view.frame()?.camera?.eye) turn.place();
    };
    view.on("frame", showHandle);

    const show = () => {
      buttons.forEach((one, n) => one.setAttribute("aria-checked", String(slices.layout() === LAYOUTS[n][0])));
      rest.hidden = slices.layout() === "volume";
      const window_ = slices.window();
      if (window_) {
        const ends = [Math.min(range()[0], window_[0]), Math.max(range()[1], window_[1])];
        black.show(window_[0], ends);
        white.show(window_[1], ends);
      }
      if (slices.point()) where.textContent = `Cross-hair at ${placeText(slices.point(), layers.volume())}`;
      clip.show(slices.options.clip);
      showHandle();
    };
    slices.on(show);
    show();
    return h("div", { class: "slices-panel" }, group, rest);
  },
};
