// The bar above the picture: standpoints, ways to turn, undo, bookmarks, what is shown.
import { h } from "./dom.js";
import { travelSeconds } from "./gestures.js";
import { helpSheet } from "./help.js";
import { iconButton } from "./icons.js";
import { menu } from "./menu.js";
import { directions, isAnatomical } from "./seen.js";

const TURNINGS = {
  turntable: "Turntable: what stands upright stays so",
  trackball: "Trackball: turns freely",
  fly: "Fly: keys move, the pointer looks round",
};
const HANDS = { orbit: "Turn", pan: "Move sideways", dolly: "Nearer and farther", roll: "Roll", window: "Window and level" };
const SHOWN = { cube: "Orientation cube", scale: "Scale bar", status: "Size and frames a second" };
const VIEWED = ["front", "back", "left", "right", "top", "bottom"];

/** The bar of a view; root is what becomes full screen and shows panels. Returns { element, commands }. */
export function toolbar(view, root) {
  const travel = (gesture) => view.gesture({ ...gesture, seconds: travelSeconds() });
  const keep = (changes) => view.send({ type: "habits", ...changes });
  const asked = (what, args) => view.ask(what, args).catch((error) => view.tell("error", error));

  const views = () => {
    const order = [3, 2, 0, 1, 4, 5]; // front looks from -y
    const all = directions(isAnatomical(view));
    const named = VIEWED.map((name, n) => {
      const text = isAnatomical(view) ? `${all[order[n]].name} (${all[order[n]].letter})` : `from ${all[order[n]].letter}`;
      return { text: text[0].toUpperCase() + text.slice(1), hint: String(n + 1), run: () => travel({ kind: "view", name }) };
    });
    const corner = { text: "From a corner", hint: "7", run: () => travel({ kind: "view", name: "iso" }) };
    const home = { text: "Back to the first view", hint: "Home", run: () => travel({ kind: "reset" }) };
    const checked = view.frame()?.camera?.name === "orthographic";
    const rays = { text: "Parallel rays", hint: "O", checked, run: toParallel };
    return [...named, corner, "-", home, rays];
  };
  const marks = () => {
    const kept = (view.habits()?.bookmarks ?? []).map(({ name, whole }) => ({
      text: whole ? `${name} (all settings)` : name,
      run: () => travel({ kind: "recall", name }),
      remove: () => asked("bookmarks.remove", { name }),
    }));
    const add = (whole) => () => nameBookmark(whole);
    const camera = { text: "Keep this view …", hint: "B", run: add(false) };
    return [camera, { text: "Keep all settings, too …", run: add(true) }, ...(kept.length ? ["-"] : []), ...kept];
  };
  const nameBookmark = (whole) => {
    const input = h("input", { type: "text", maxlength: 80, "aria-label": "Name of the bookmark", placeholder: "name" });
    const cancel = h("button", { type: "button", onclick: () => dialog.close("") }, "Cancel");
    const form = h("form", { method: "dialog" }, h("h2", {}, whole ? "Keep all settings" : "Keep this view"), input,
      h("div", { class: "row" }, h("button", { value: "keep" }, "Keep"), cancel));
    const dialog = h("dialog", { class: "ask-sheet", "aria-label": "Bookmark" }, form);
    dialog.addEventListener("close", () => {
      if (dialog.returnValue === "keep") asked("bookmarks.add", { name: input.value, whole });
      dialog.remove();
    });
    root.append(dialog);
    dialog.showModal();
  };
  const hand = ([kind, text]) => ({ text, choice: true, checked: view.hand === kind, run: () => setHand(kind) });
  const hands = () => Object.entries(HANDS).map(hand);
  const setHand = (kind) => {
    view.hand = kind;
    view.tell("said", `A drag makes: ${HANDS[kind]}`);
  };
  const toggled = (name) => {
    const hidden = view.habits()?.hidden ?? [];
    keep({ hidden: hidden.includes(name) ? hidden.filter((other) => other !== name) : [...hidden, name] });
  };
  const part = ([name, text]) => ({ text, checked: !view.habits()?.hidden.includes(name), run: () => toggled(name) });
  const shown = () => Object.entries(SHOWN).map(part);

  const off = { "aria-pressed": "false" };
  const turning = ([name, label]) => [name, iconButton(name, label, () => keep({ turning: name }), off)];
  const turnings = Object.entries(TURNINGS).map(turning);
  const toParallel = () => view.gesture({ kind: "orthographic" });
  const parallel = iconButton("orthographic", "Parallel rays (O)", toParallel, { class: "tool roomy", ...off });
  const fit = iconButton("fit", "Show all of it (0)", () => travel({ kind: "fit" }));
  const home = iconButton("reset", "Back to the first view (Home)", () => travel({ kind: "reset" }), { class: "tool roomy" });
  const undo = iconButton("undo", "Undo (Ctrl+Z)", () => view.undo());
  const redo = iconButton("redo", "Redo (Ctrl+Y)", () => view.redo());
  const full = iconButton("screen", "Full screen", () => {
    const now = root.getRootNode().fullscreenElement ?? document.fullscreenElement;
    if (now) document.exitFullscreen();
    else root.requestFullscreen?.().catch((error) => view.tell("error", { what: String(error) }));
  });
  let sheet = null;
  const help = () => {
    if (!sheet) root.append((sheet = helpSheet(view.schema.bindings)));
    if (!sheet.open) sheet.showModal();
  };
  const turnPanels = () => showPanels(root.classList.contains("no-side"));
  const panels = iconButton("panels", "Panels (P)", turnPanels, { "aria-pressed": "true" });
  const showPanels = (on) => {
    root.classList.toggle("no-side", !on);
    panels.setAttribute("aria-pressed", String(on));
  };
  if (matchMedia("(max-width: 640px)").matches) showPanels(false);

  const marked = menu({ name: "bookmark", label: "Bookmarks", items: marks });
  const leads = h("p", { class: "leads", hidden: true }, "Follows another view");
  const group = (label, ...children) => h("div", { class: "group", role: "group", "aria-label": label }, children);
  const changing = [
    group("Standpoint", menu({ name: "views", label: "Views", items: views }), fit, home, parallel),
    group("History", undo, redo),
    group("Ways to turn", ...turnings.map(([, button]) => button)),
    group("Drag", menu({ name: "hand", label: "What a drag does", items: hands })),
    group("Bookmarks", marked),
  ];
  const element = h("div", { class: "toolbar", role: "toolbar", "aria-label": "View" },
    h("div", { class: "tools" },
      leads, changing,
      group("Shown", menu({ name: "shown", label: "Shown over the picture", items: shown }), full)),
    h("div", { class: "tools-end" }, iconButton("help", "Gestures and keys (?)", help), panels));

  view.on("state", (state) => {
    leads.hidden = !state.following;
    for (const one of changing) one.inert = state.following;
    undo.disabled = !state.can_undo;
    redo.disabled = !state.can_redo;
    for (const [name, button] of turnings) button.setAttribute("aria-pressed", String(state.habits?.turning === name));
  });
  view.on("frame", (frame) => parallel.setAttribute("aria-pressed", String(frame.camera?.name === "orthographic")));
  const commands = { help, panels: turnPanels, status: () => toggled("status"), undo: view.undo, redo: view.redo };
  return { element, commands };
}
