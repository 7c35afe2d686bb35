// Icons, drawn as strokes on 24 by 24.
import { h } from "./dom.js";

const PATHS = {
  views: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM12 12l8-4.5M12 12v9M12 12L4 7.5",
  fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5M9 9h6v6H9z",
  reset: "M4 11l8-7 8 7M6 10v9h12v-9M10 19v-5h4v5",
  orthographic: "M4 7h16M4 12h16M4 17h16M17 4l3 3-3 3M17 14l3 3-3 3",
  turntable: "M4 16c0 2 3.6 4 8 4s8-2 8-4-3.6-4-8-4M12 12V3M9 6l3-3 3 3M4 16c0-1 1-2 2-2.6",
  trackball: "M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM3.5 10c5 3 12 3 17 0M10 3.5c-3 5-3 12 0 17",
  fly: "M3 12l18-8-7 17-3-7z",
  hand:
    "M8 12V5.5a1.5 1.5 0 0 1 3 0V11M11 10V4.5a1.5 1.5 0 0 1 3 0V11" +
    "M14 10V6a1.5 1.5 0 0 1 3 0v8a7 7 0 0 1-7 7c-3 0-4-2-6-6.5-.6-1.5 1-2.5 2-1.3L8 15",
  undo: "M8 5L4 9l4 4M4 9h10a5 5 0 0 1 0 10h-4",
  redo: "M16 5l4 4-4 4M20 9H10a5 5 0 0 0 0 10h4",
  bookmark: "M6 3h12v18l-6-5-6 5z",
  shown: "M2 12c3-5 6-7 10-7s7 2 10 7c-3 5-6 7-10 7s-7-2-10-7zM12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
  screen: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
  help: "M8.5 9a3.5 3.5 0 1 1 5 3c-1 .6-1.5 1.2-1.5 2.5M12 18v.5",
  panels: "M3 4h18v16H3zM15 4v16M17.5 8h1M17.5 12h1",
  close: "M5 5l14 14M19 5L5 19",
};

/** An icon by its name; readers are told by the button that it is in. */
export const icon = (name) =>
  h("svg", { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true", focusable: "false" }, h("path", { d: PATHS[name] }));

/** A button that shows an icon, and tells readers and pointers what it does. */
export const iconButton = (name, label, run, given = {}) =>
  h("button", { class: "tool", type: "button", "aria-label": label, title: label, onclick: run, ...given }, icon(name));
