// The front-end of the viewer: the picture, what is above it, and the panels beside it.
import { h } from "./dom.js";
import { makeView } from "./view.js";
import { attachPointer } from "./pointer.js";
import { attachKeys } from "./keys.js";
import { pictureOverlay } from "./overlay.js";
import { toolbar } from "./toolbar.js";
import { attachDrop, entrance } from "./opening.js";
import { progressBar } from "./progress.js";
import { panels } from "./panels/index.js";

const FOLDED = 15; // panels of this order and beyond are closed at first

export default {
  render({ model, el }) {
    const told = { role: "application", "aria-roledescription": "volume view", "aria-label": "Volume" };
    const canvas = h("canvas", { class: "picture", tabindex: 0, ...told });
    const overlay = h("svg", { class: "overlay", role: "group", "aria-label": "Handles in the picture" });
    const words = h("p", { class: "words", role: "status", "aria-live": "polite" });
    const stage = h("div", { class: "stage" }, canvas, overlay, words);
    const side = h("aside", { class: "side", "aria-label": "Panels" });
    const panes = h("div", { class: "panes" }, stage); // slices lie beside it
    const middle = h("div", { class: "middle" }, panes);
    const root = h("div", { class: "airlight" }, middle, side);
    el.replaceChildren(root);
    // Cells of notebooks are as high as what is in them.
    const height_px = model.get?.("height_px");
    if (height_px) root.style.height = `${height_px}px`;

    const view = makeView(model, canvas, overlay);
    view.stage = stage;
    const bar = toolbar(view, root);
    middle.prepend(bar.element);
    stage.append(pictureOverlay(view), entrance(view), progressBar(view));
    const size = () => {
      const ratio = globalThis.devicePixelRatio || 1;
      return [stage.clientWidth, stage.clientHeight].map((n) => Math.max(1, Math.round(n * ratio)));
    };
    const hello = () => view.send({ type: "hello", size_px: size(), ratio: globalThis.devicePixelRatio || 1 });
    model.on("msg:open", hello);
    const observer = new ResizeObserver(() => view.send({ type: "size", size_px: size() }));
    observer.observe(stage);
    view.on("state", () => {
      // Panels get a finished view: the schema comes first, then the state.
      if (side.childElementCount) return;
      for (const panel of [...panels].sort((a, b) => a.order - b.order)) {
        const given = { class: "panel", open: panel.order < FOLDED, "data-always": panel.always };
        side.append(h("details", given, h("summary", {}, panel.title), panel.build(view)));
      }
    });
    view.on("error", (error) => (words.textContent = [error.where, error.what, error.remedy].filter(Boolean).join(" ")));
    let revision = -1;
    view.on("state", ({ rev, following }) => {
      if (rev !== revision) words.textContent = "";
      revision = rev;
      root.classList.toggle("follows", following);
      for (const panel of side.children) panel.lastElementChild.inert = following && !panel.hasAttribute("data-always");
    });
    const detach = [() => model.off?.("msg:open", hello), view.end, attachPointer(view), attachKeys(view, root, bar.commands), attachDrop(view, root)];
    hello();
    return () => {
      observer.disconnect();
      detach.forEach((end) => end());
    };
  },
};
