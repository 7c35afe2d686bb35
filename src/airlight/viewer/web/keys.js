// What keys do while the picture has the focus; undo and redo wherever no text is edited.
import { bound, modifiersOf, travelSeconds } from "./gestures.js";

const TAP_S = 0.12; // what a short press of a held key is worth at least
const STANDPOINTS = new Set(["fit", "reset", "view", "recall"]);

/** The name of a key in the table: letters small, plus with or without Shift. */
export function keyName(event) {
  if (event.key === "=" || event.key === "Add") return "+";
  if (event.key === "_" || event.key === "Subtract") return "-";
  return event.key.length === 1 ? event.key.toLowerCase() : event.key;
}

/** The gesture of a held key over some seconds; Shift makes fast ones faster. */
export function heldGesture(entry, seconds, shift) {
  const factor = seconds * (shift ? entry.fast ?? 1 : 1);
  const amounts = ["dx", "dy", "dz"].filter((name) => entry[name]).map((name) => [name, entry[name] * factor]);
  return { kind: entry.kind, ...Object.fromEntries(amounts) };
}

/** Send gestures of keys; commands are { name: function } of the host. Returns what ends it. */
export function attachKeys(view, root, commands) {
  const held = new Map();
  let shift = false;
  let last = 0;
  let ticking = 0;

  const tick = (now) => {
    const seconds = Math.max(0, Math.min((now - last) / 1000, 0.1));
    last = now;
    for (const entry of held.values()) view.gesture(heldGesture(entry, seconds, shift));
    ticking = held.size ? requestAnimationFrame(tick) : 0;
  };
  const take = (entry, event) => {
    event.preventDefault();
    event.stopPropagation();
    if (entry.held) {
      if (event.repeat) return;
      view.gesture(heldGesture(entry, TAP_S, event.shiftKey));
      held.set(event.code, entry);
      shift = event.shiftKey;
      last = performance.now();
      ticking ||= requestAnimationFrame(tick);
    } else if (entry.command) (commands[entry.command] ?? (() => view.tell(entry.command)))();
    else if (!event.repeat) {
      const { kind, name, dx } = entry;
      view.gesture({ kind, ...(name ? { name } : {}), ...(dx ? { dx } : {}), ...(STANDPOINTS.has(kind) ? { seconds: travelSeconds() } : {}) });
    }
  };
  const press = (event) => {
    view.canvas.classList.remove("pointed");
    const modifiers = modifiersOf(event);
    const entry = bound(view.schema?.bindings, "key", keyName(event), modifiers, view.habits()?.turning);
    // With Control and Alt, only what names them: all else is the browser's.
    if (entry && (entry.modifier === "Control" || !modifiers.some((name) => name !== "Shift"))) take(entry, event);
  };
  const release = (event) => {
    shift = event.shiftKey;
    held.delete(event.code);
  };
  const leave = () => held.clear();
  const everywhere = (event) => {
    const writes = event.target.closest?.("input:not([type=checkbox]):not([type=range]):not([type=color]), textarea, select");
    if (event.defaultPrevented || writes || !(event.ctrlKey || event.metaKey)) return;
    const name = event.shiftKey && keyName(event) === "z" ? "y" : keyName(event);
    const entry = bound(view.schema?.bindings, "key", name, ["Control"], view.habits()?.turning);
    if (entry?.command && entry.modifier === "Control") take(entry, event);
  };
  const attached = [
    [view.canvas, "keydown", press],
    [view.canvas, "keyup", release],
    [view.canvas, "blur", leave],
    [root, "keydown", everywhere],
  ];
  attached.forEach(([element, name, listener]) => element.addEventListener(name, listener));
  return () => {
    cancelAnimationFrame(ticking);
    attached.forEach(([element, name, listener]) => element.removeEventListener(name, listener));
  };
}
