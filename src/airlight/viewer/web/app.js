// The front-end of the viewer: the picture, what is above it, and the panels beside it.
import { h } from "./dom.js";
import { makeView } from "./view.js";
import { attachPointer } from "./pointer.js";
import { panels } from "./panels/index.js";

export default {
  render({ model, el }) {
    const canvas = h("canvas", { class: "picture", role: "img", "aria-label": "Volume", tabindex: 0 });
    const overlay = h("svg", { class: "overlay", "aria-hidden": "true" });
    const words = h("p", { class: "words", role: "status", "aria-live": "polite" });
    const stage = h("div", { class: "stage" }, canvas, overlay, words);
    const side = h("aside", { class: "side", "aria-label": "Panels" });
    const root = h("div", { class: "airlight" }, stage, side);
    el.replaceChildren(root);

    const view = makeView(model, canvas, overlay);
    view.stage = stage;
    const size = () => {
      const ratio = globalThis.devicePixelRatio || 1;
      return [stage.clientWidth, stage.clientHeight].map((n) => Math.max(1, Math.round(n * ratio)));
    };
    const hello = () => view.send({ type: "hello", size_px: size(), ratio: globalThis.devicePixelRatio || 1 });
    model.on("msg:open", hello);
    const observer = new ResizeObserver(() => view.send({ type: "size", size_px: size() }));
    observer.observe(stage);
    view.on("welcome", () => {
      if (side.childElementCount) return;
      for (const panel of [...panels].sort((a, b) => a.order - b.order)) {
        side.append(h("details", { class: "panel", open: panel.order < 40 }, h("summary", {}, panel.title), panel.build(view)));
      }
    });
    view.on("error", (error) => (words.textContent = [error.where, error.what, error.remedy].filter(Boolean).join(" ")));
    view.on("state", () => (words.textContent = ""));
    const detach = attachPointer(view, stage);
    hello();
    return () => {
      observer.disconnect();
      detach();
    };
  },
};
