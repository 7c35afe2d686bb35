// Menus under buttons: arrow keys walk, Escape and a click elsewhere close.
import { h, fill } from "./dom.js";
import { iconButton } from "./icons.js";

/**
 * A button with a menu. items() lists what is in it when it opens: { text, hint?, checked?, run, remove? } or "-" for a line;
 * checked makes it a choice, remove adds a small button that takes the entry away.
 */
export function menu({ name, label, items }) {
  const list = h("div", { class: "airlight-menu", role: "menu", "aria-label": label, popover: "auto" });
  const button = iconButton(name, label, null, { "aria-haspopup": "menu", "aria-expanded": "false" });
  const entries = () => [...list.querySelectorAll("[role^=menuitem]")];

  const entry = (item) => {
    if (item === "-") return h("div", { class: "line", role: "separator" });
    const role = item.checked === undefined ? "menuitem" : item.choice ? "menuitemradio" : "menuitemcheckbox";
    const run = () => {
      list.hidePopover();
      button.focus();
      item.run();
    };
    const given = { role, type: "button", tabindex: -1, onclick: run };
    if (item.checked !== undefined) given["aria-checked"] = String(item.checked);
    const tick = h("span", { class: "tick", "aria-hidden": "true" }, item.checked ? "✓" : "");
    const main = h("button", given, tick, h("span", {}, item.text), item.hint ? h("kbd", {}, item.hint) : null);
    if (!item.remove) return main;
    const gone = () => {
      list.hidePopover();
      button.focus();
      item.remove();
    };
    const away = iconButton("close", `Remove ${item.text}`, gone, { role: "menuitem", tabindex: -1, class: "gone" });
    return h("div", { class: "pair", role: "none" }, main, away);
  };
  button.addEventListener("click", () => {
    if (list.matches(":popover-open")) return list.hidePopover();
    fill(list, items().map(entry));
    list.showPopover();
    const from = button.getBoundingClientRect();
    list.style.left = `${Math.max(4, Math.min(from.left, innerWidth - list.offsetWidth - 4))}px`;
    list.style.top = `${Math.min(from.bottom + 4, innerHeight - list.offsetHeight - 4)}px`;
    entries()[0]?.focus();
  });
  list.addEventListener("toggle", (event) => button.setAttribute("aria-expanded", String(event.newState === "open")));
  list.addEventListener("keydown", (event) => {
    const all = entries();
    const n = all.indexOf(event.target.getRootNode().activeElement);
    const [next, before] = [n + 1, n - 1];
    const keys = { ArrowDown: next, ArrowRight: next, ArrowUp: before, ArrowLeft: before, Home: 0, End: all.length - 1 };
    const to = keys[event.key];
    if (to === undefined) return;
    event.preventDefault();
    all[(to + all.length) % all.length]?.focus();
  });
  return h("span", { class: "menu-holder" }, button, list);
}
