// Opening volumes: files that are dropped or chosen travel in pieces; and what is shown before anything is open.
import { h, fill } from "./dom.js";

const PIECE = 1 << 20;

/** Bring files of one volume and open them: way is "replace" or "layer". */
export async function bring(view, files, way) {
  const { upload } = await view.ask("files.begin", { names: files.map((file) => file.name), sizes: files.map((file) => file.size) });
  const what = files.length > 1 ? `bringing ${files.length} files` : `bringing ${files[0].name}`;
  for (const [n, file] of files.entries()) {
    for (let at = 0; at < file.size; at += PIECE) {
      const data = await file.slice(at, at + PIECE).arrayBuffer();
      const { done, total } = await view.ask("files.piece", { upload, file: n, at }, [data]);
      if (done < total) view.tell("progress", { what, done, total });
    }
  }
  return view.ask("files.open", { upload, way });
}

/** Do something that opens, and tell what goes wrong. */
export async function opened(view, work) {
  try {
    await work();
  } catch (error) {
    view.tell("error", error.what ? error : { what: String(error) });
  }
}

/** A button that lets the user choose files. */
export function chooser(view, label, way) {
  const input = h("input", { type: "file", multiple: true, hidden: true, "aria-label": label, onchange: () => {
    const files = [...input.files];
    input.value = "";
    if (files.length) opened(view, () => bring(view, files, way));
  } });
  return h("span", {}, h("button", { type: "button", onclick: () => input.click() }, label), input);
}

/** Files that were dropped, those of folders, too. */
async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return [...transfer.files];
  const found = [];
  const walk = async (entry) => {
    if (entry.isFile) return found.push(await new Promise((resolve, reject) => entry.file(resolve, reject)));
    const reader = entry.createReader();
    for (let batch; (batch = await new Promise((resolve, reject) => reader.readEntries(resolve, reject))).length;) {
      for (const inner of batch) await walk(inner);
    }
  };
  for (const entry of entries) await walk(entry);
  return found;
}

/** Let files be dropped anywhere on the view: two fields say what becomes of them. */
export function attachDrop(view, root) {
  const field = (way, text) => h("div", { class: "drop-field", "data-way": way }, text);
  const layer = field("layer", "Add as a layer");
  const sheet = h("div", { class: "drop-sheet", hidden: true }, field("replace", "Open"), layer);
  root.append(sheet);
  const has = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");
  const over = (event) => {
    if (!has(event)) return;
    event.preventDefault();
    sheet.hidden = false;
    const at = event.target.closest?.(".drop-field");
    for (const each of sheet.children) each.classList.toggle("over", each === at);
  };
  const leave = (event) => {
    if (!root.contains(event.relatedTarget)) sheet.hidden = true;
  };
  const drop = (event) => {
    if (!has(event)) return;
    event.preventDefault();
    sheet.hidden = true;
    const way = event.target.closest?.(".drop-field")?.dataset.way ?? "replace";
    const files = dropped(event.dataTransfer);
    opened(view, async () => bring(view, await files, way));
  };
  const heard = { dragenter: over, dragover: over, dragleave: leave, drop };
  for (const [name, listener] of Object.entries(heard)) root.addEventListener(name, listener);
  return () => {
    for (const [name, listener] of Object.entries(heard)) root.removeEventListener(name, listener);
  };
}

/** What is above the empty picture of a viewer that shows nothing yet. */
export function entrance(view) {
  const list = h("div", { class: "entrance-list" });
  const element = h("section", { class: "entrance", "aria-label": "Open", hidden: true },
    h("h2", {}, "Nothing is open yet"), h("p", {}, "Drop a file here, or"), chooser(view, "Open a file …", "replace"), list);
  let name = null;
  view.on("state", async (state) => {
    if (state.name === name) return;
    name = state.name;
    const found = await view.ask("files").catch(() => null);
    if (!found) return;
    element.hidden = !found.nothing;
    if (!found.nothing) return;
    const open = (given, text, title) => h("button", { type: "button", title, onclick: () => opened(view, () => view.ask("files.open", given)) }, text);
    fill(list,
      found.files.length ? h("h3", {}, found.folder) : null, found.files.map((file) => open({ id: file.id }, file.name, sized(file.bytes))),
      h("h3", {}, "Samples"), found.samples.map((sample) => open({ sample: sample.name }, sample.name, sample.title)));
  });
  return element;
}

/** Bytes, as people read them. */
export const sized = (bytes) => (bytes >= 1e9 ? `${(bytes / 1e9).toPrecision(2)} GB` : bytes >= 1e6 ? `${(bytes / 1e6).toPrecision(3)} MB` : bytes ? `${Math.ceil(bytes / 1e3)} kB` : "folder");
