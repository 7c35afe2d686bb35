// Opening: files of the user, volumes of the folder that was opened, samples.
import { h, fill } from "../dom.js";
import { chooser, opened, sized } from "../opening.js";

export const panel = {
  title: "Open",
  order: 80,
  build(view) {
    const list = h("div", {});
    const ask = (given) => opened(view, () => view.ask("files.open", given));
    const row = (given, name, note) => h("li", { class: "row file" }, h("strong", {}, name), h("span", { class: "unit" }, note),
      h("button", { type: "button", "aria-label": `Open ${name}`, onclick: () => ask(given) }, "Open"),
      h("button", { type: "button", "aria-label": `Add ${name} as a layer`, title: "Add as a layer", onclick: () => ask({ ...given, way: "layer" }) }, "+"));
    const show = ({ folder, files, samples, most_bytes }) => fill(list,
      folder === null ? null : h("h3", {}, folder),
      folder === null ? null : files.length ? h("ul", { class: "list" }, files.map((file) => row({ id: file.id }, file.name, sized(file.bytes)))) : h("p", { class: "help" }, "This folder holds no volumes."),
      h("details", {}, h("summary", {}, "Samples"), h("ul", { class: "list" }, samples.map((sample) => row({ sample: sample.name }, sample.name, sample.title)))),
      h("p", { class: "help" }, `Files may be dropped anywhere on the view: of up to ${sized(most_bytes)}. They are read on the machine that draws, in a process of its own, and deleted then.`));
    view.ask("files").then(show, (error) => view.tell("error", error));
    return h("div", { class: "files" }, h("div", { class: "row" }, chooser(view, "Open a file …", "replace"), chooser(view, "Add as a layer …", "layer")), list);
  },
};
