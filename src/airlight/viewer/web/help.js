// The help sheet: all gestures and keys, from the table that makes them.
import { h } from "./dom.js";
import { iconButton } from "./icons.js";

const POINTERS = {
  left: "drag", middle: "drag with the middle button", right: "drag with the right button", wheel: "wheel",
  double: "double click or tap", pinch: "two fingers apart, together", two: "drag with two fingers", twist: "turn two fingers",
};
const KEYS = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Control: "Ctrl", " ": "Space" };

/** What makes an entry of the table, in words or as it is written on keys. */
export function madeBy(entry) {
  const onKey = () => KEYS[entry.key] ?? (entry.key.length === 1 ? entry.key.toUpperCase() : entry.key);
  const name = entry.pointer ? POINTERS[entry.pointer] ?? entry.pointer : onKey();
  return [...(entry.modifier ? [KEYS[entry.modifier] ?? entry.modifier] : []), name];
}

/** Groups of the table: pointer, keys, keys while flying, as { title, entries }. */
export function groupsOf(bindings) {
  const flying = (entry) => entry.turning === "fly";
  return [
    { title: "Pointer and fingers", entries: bindings.filter((entry) => entry.pointer) },
    { title: "Keys, while the picture has the focus", entries: bindings.filter((entry) => entry.key && !flying(entry)) },
    { title: "Keys while flying; Shift is faster", entries: bindings.filter((entry) => entry.key && flying(entry)) },
  ];
}

/** Entries of one meaning together, as [help, entries]. */
export const byMeaning = (entries) =>
  [...new Set(entries.map((entry) => entry.help))].map((help) => [help, entries.filter((entry) => entry.help === help)]);

/** A dialog with all of it. */
export function helpSheet(bindings) {
  const made = (entry) => h("span", { class: "keys" }, madeBy(entry).map((part) => h("kbd", {}, part)));
  const row = ([help, entries]) => h("div", { class: "help-row" }, h("dd", {}, help), h("dt", {}, entries.map(made)));
  const group = ({ title, entries }) => h("section", {}, h("h3", {}, title), h("dl", {}, byMeaning(entries).map(row)));
  const dialog = h("dialog", { class: "help-sheet", "aria-label": "Gestures and keys" });
  const close = iconButton("close", "Close", () => dialog.close());
  const head = h("header", {}, h("h2", {}, "Gestures and keys"), close);
  dialog.append(head, h("div", { class: "help-groups" }, groupsOf(bindings).map(group)));
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  return dialog;
}
