// The function as Python, to a file and from one; the library reads and writes them.
import { h } from "../dom.js";
import { button } from "../controls.js";
import { download } from "../download.js";
import { asked } from "./target.js";

/** Buttons: copy, save, load. */
export function fileButtons({ view, edited }) {
  const text = h("textarea", { readonly: true, rows: 6, hidden: true, "aria-label": "Python of the function" });
  const show = (code) => {
    text.hidden = false;
    text.value = code;
    text.select();
  };
  async function copy() {
    const { code } = await view.ask("transfer.code", { layer: edited.target().layer });
    // Where the clipboard may not be written to, the text is there to be copied.
    await navigator.clipboard.writeText(code).then(
      () => view.tell("said", "The function is copied as Python."),
      () => show(code),
    );
  }
  async function save() {
    const found = await view.ask("transfer.file", asked(edited.target()));
    download(found.name, "application/toml", found.text);
  }
  async function load() {
    const [given] = input.files;
    if (!given) return;
    const found = await view.ask("transfer.read", { name: given.name, text: await given.text() });
    // Functions of several variables and mixtures are those of a layer.
    edited.take(found.transfer, found.transfer.points ? undefined : { path: edited.layers.path("transfer") });
  }
  const input = h("input", {
    type: "file",
    accept: ".toml,.json",
    hidden: true,
    "aria-label": "file of a transfer function",
    onchange: () =>
      load()
        .catch(edited.fail)
        .finally(() => (input.value = "")),
  });
  const safely = (work) => () => work().catch(edited.fail);
  return h(
    "div",
    {},
    h(
      "div",
      { class: "line" },
      button("Copy as code", safely(copy)),
      button("Save", safely(save)),
      button("Load", () => input.click()),
      input,
    ),
    text,
  );
}
