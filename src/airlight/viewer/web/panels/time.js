// Time steps: a slider, and play.
import { h } from "../dom.js";
import { button } from "../controls.js";
import { layersOf } from "../layers.js";

const STEP_MS = 250;

export const panel = {
  title: "Time",
  order: 5,
  build(view) {
    const layers = layersOf(view);
    const slider = h("input", { type: "range", min: 0, step: 1, "aria-label": "time step", oninput: () => put(slider.valueAsNumber) });
    const told = h("output", {});
    let timer = 0;
    let off = () => {};
    const steps = (layer) => layers.volumeOf(layer)?.times ?? 1;
    const times = () => Math.max(1, ...layers.all().map(steps));
    const now = () => Math.max(0, ...layers.all().map((layer) => layer.time ?? 0));
    // All layers that have so many steps go together.
    const put = (time) => view.ops(layers.all().flatMap((layer, n) =>
      time < steps(layer) ? [{ op: "set", path: ["scene", "layers", n, "time"], value: time }] : []), "time");
    const stop = () => {
      clearInterval(timer);
      off();
      timer = 0;
      play.textContent = "Play";
    };
    const play = button("Play", () => {
      if (timer) return stop();
      play.textContent = "Stop";
      // A step is asked for once the one before has been shown.
      let shown = true;
      off = view.on("frame", () => (shown = true));
      timer = setInterval(() => {
        if (shown) {
          shown = false;
          put((now() + 1) % times());
        }
      }, STEP_MS);
    });
    const element = h("div", { class: "row" }, play, slider, told);
    const show = () => {
      const count = times();
      slider.max = count - 1;
      if (!slider.matches(":active")) slider.value = now();
      told.textContent = `${now() + 1} of ${count}`;
      slider.setAttribute("aria-valuetext", told.textContent);
      const panel = element.closest("details");
      if (panel) panel.hidden = count < 2;
    };
    view.on("state", show);
    queueMicrotask(show);
    return element;
  },
};
