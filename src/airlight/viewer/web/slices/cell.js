// One slice: its picture, cross-hair, letters and scale bar, and what pointer, wheel and keys do to it.
import { fill, h } from "../dom.js";
import { choice } from "../controls.js";
import { stroke } from "../editor/steady.js";
import { placeText } from "../seen.js";
import { cross, dot, minus, plus, times } from "../vectors.js";
import { along, inverseRows, placeOf, voxelStep, waysOf, worldAt } from "./geometry.js";

const PLAIN = { axial: "x y", coronal: "x z", sagittal: "y z", oblique: "oblique" };
const COLOURS = { axial: "#6ab0ff", coronal: "#7ed67e", sagittal: "#ff8a7a", oblique: "#ffd75e" };
const ZOOM = 1.15;
const MOST_PX = 1024;

/**
 * A slice with its name chosen from a list: { element, plane(), show(data, told), mark(), reset(), size(), name() }.
 * `all` is what slices share: { panes, layers, options, volume(), point(), normal(), window(), setWindow, move, draw }.
 */
export function makeCell(view, all, first) {
  const { options, layers, volume, setWindow, move, draw } = all;
  let name = first;
  let zoom = 1;
  let aside = [0, 0]; // of the middle, in world units to the right and up
  let told = null;
  const canvas = h("canvas", { class: "slice-picture" });
  const svg = h("svg", { class: "slice-above", "aria-hidden": "true" });
  const value = h("span", { class: "slice-value" });
  const words = (one) => (volume()?.anatomical ? one : PLAIN[one]);
  const select = choice([], `plane of slice`, (chosen) => {
    name = chosen;
    reset();
    draw();
  });
  const face = h(
    "div",
    { class: "slice-face", tabindex: 0, role: "application", "aria-roledescription": "slice" },
    canvas,
    svg,
  );
  const element = h("section", { class: "slice" }, face, h("div", { class: "slice-head" }, select.element, value));
  all.panes.append(element);

  const size = () => [face.clientWidth, face.clientHeight];
  const reset = () => {
    zoom = 1;
    aside = [0, 0];
    select.put(Object.keys(COLOURS).map((one) => [one, words(one)]));
    select.show(name);
    element.style.setProperty("--slice", COLOURS[name]);
  };
  const ways = () => waysOf(name, view.frame()?.camera, options.facing ? null : all.normal());
  const normalOf = () => {
    const { right, up } = ways();
    return cross(right, up);
  };
  /** Where the slice lies now: middle, ways, and world units a CSS pixel. */
  const placed_ = () => {
    const { right, up } = ways();
    const corners = volume().corners_world;
    const [wide, high] = [along(corners, right), along(corners, up)];
    const [width, height] = size();
    const pixel = (1.04 * Math.max((wide[1] - wide[0]) / width, (high[1] - high[0]) / height)) / zoom;
    const middle = times(plus(volume().low_world, volume().high_world), 0.5);
    const toward = cross(right, up);
    const centre = plus(plus(plus(middle, toward, dot(minus(all.point(), middle), toward)), right, aside[0]), up, aside[1]);
    return { centre, right, up, pixel };
  };
  const plane = () => {
    const at = placed_();
    const [width, height] = size();
    const finer = Math.min(globalThis.devicePixelRatio || 1, MOST_PX / Math.max(width, height));
    const size_px = [width, height].map((n) => Math.max(1, Math.round(n * finer)));
    return {
      at,
      asked: { centre_world: at.centre, right: at.right, up: at.up, pixel_world: (at.pixel * width) / size_px[0], size_px },
    };
  };
  async function show(data, found) {
    const bitmap = await createImageBitmap(new Blob([data], { type: "image/png" }), { colorSpaceConversion: "none" });
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
    canvas.getContext("2d").drawImage(bitmap, 0, 0);
    bitmap.close();
    told = found;
    mark();
  }
  /** Cross-hair, letters and scale bar. */
  function mark() {
    if (!all.point() || !volume() || !view.frame()?.camera?.eye || size()[0] < 2) return;
    const [width, height] = size();
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const at = placed_();
    const [x, y] = placeOf(at, [width, height], all.point());
    const others = {
      axial: ["sagittal", "coronal"],
      coronal: ["sagittal", "axial"],
      sagittal: ["coronal", "axial"],
      oblique: ["oblique", "oblique"],
    }[name];
    const gap = 9;
    const line = (d, colour) => {
      const path = h("path", { d });
      path.style.stroke = COLOURS[colour];
      return path;
    };
    const text = (word, tx, ty, anchor) => h("text", { x: tx, y: ty, "text-anchor": anchor }, word);
    const letters = told?.letters;
    const bar = told ? (told.bar_px / canvas.width) * width : 0;
    fill(
      svg,
      line(`M${x} 0V${y - gap}M${x} ${y + gap}V${height}`, others[0]),
      line(`M0 ${y}H${x - gap}M${x + gap} ${y}H${width}`, others[1]),
      letters && [
        text(letters.left, 6, height / 2 - 6, "start"),
        text(letters.right, width - 6, height / 2 - 6, "end"),
        text(letters.up, width / 2 + 6, 18, "start"),
        text(letters.down, width / 2 + 6, height - 8, "start"),
      ],
      told && [h("path", { class: "slice-bar", d: `M8 ${height - 8}h${bar}` }), text(told.bar, 8, height - 14, "start")],
    );
    face.setAttribute("aria-label", `${words(name)} slice at ${placeText(all.point(), volume())}`);
  }

  // -- what pointer, wheel and keys do
  const held = new Map();
  const local = (event) => {
    const box = face.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const handOf = (event) =>
    ({ 0: event.shiftKey ? "pan" : event.ctrlKey ? "zoom" : options.hand, 1: "pan", 2: "window" })[event.button] ?? "cross";
  let keyed = stroke("cut");
  const step = (direction, steps) =>
    move(plus(all.point(), direction, steps * voxelStep(inverseRows(volume().world_from_index), direction)), keyed);
  const scroll = (steps) => step(normalOf(), steps);
  const centre = () => size().map((n) => n / 2);
  const zoomAt = (factor, place) => {
    const before = worldAt(placed_(), size(), place);
    zoom = Math.min(50, Math.max(0.2, zoom * factor));
    const { right, up } = ways();
    const moved = minus(before, worldAt(placed_(), size(), place));
    aside = [aside[0] + dot(moved, right), aside[1] + dot(moved, up)];
  };
  const panBy = (dx, dy) => {
    const { pixel } = placed_();
    aside = [aside[0] - dx * pixel, aside[1] + dy * pixel];
  };
  face.addEventListener("pointerdown", (event) => {
    face.setPointerCapture(event.pointerId);
    const begun = { at: local(event), hand: handOf(event), merge: stroke("cut") };
    held.set(event.pointerId, begun);
    if (held.size === 1 && begun.hand === "cross") move(worldAt(placed_(), size(), begun.at), begun.merge);
  });
  face.addEventListener("pointermove", (event) => {
    const last = held.get(event.pointerId);
    const now = local(event);
    if (!last) return void hover(now);
    const [dx, dy] = [now[0] - last.at[0], now[1] - last.at[1]];
    held.set(event.pointerId, { ...last, at: now });
    // The cross-hair and the window are all slices': moving them draws.
    if (held.size === 2) {
      const other = [...held.entries()].find(([id]) => id !== event.pointerId)[1].at;
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      zoomAt(apart(now) / apart(last.at), other);
      panBy(dx / 2, dy / 2);
    } else if (last.hand === "cross") return move(worldAt(placed_(), size(), now), last.merge);
    else if (last.hand === "pan") panBy(dx, dy);
    else if (last.hand === "zoom") zoomAt(ZOOM ** (-dy / 20), centre());
    else {
      const [black, white] = all.window();
      const span = white - black;
      const grey = (black + white) / 2 + ((volume().range[1] - volume().range[0]) * dy) / 600;
      return setWindow([grey - (span / 2) * ZOOM ** (dx / 20), grey + (span / 2) * ZOOM ** (dx / 20)]);
    }
    draw();
  });
  const end = (event) => held.delete(event.pointerId);
  face.addEventListener("pointerup", end);
  face.addEventListener("pointercancel", end);
  face.addEventListener("pointerleave", () => (value.textContent = ""));
  face.addEventListener("contextmenu", (event) => event.preventDefault());
  face.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      if (!event.ctrlKey) return scroll(-Math.sign(event.deltaY));
      zoomAt(ZOOM ** -Math.sign(event.deltaY), local(event));
      draw();
    },
    { passive: false },
  );
  face.addEventListener("keydown", (event) => {
    const { right, up } = ways();
    const moves = {
      ArrowLeft: () => step(right, -1),
      ArrowRight: () => step(right, 1),
      ArrowUp: () => step(up, 1),
      ArrowDown: () => step(up, -1),
      PageUp: () => scroll(1),
      PageDown: () => scroll(-1),
    };
    const looks = { "+": () => zoomAt(ZOOM, centre()), "-": () => zoomAt(1 / ZOOM, centre()), 0: reset };
    const action = moves[event.key] ?? looks[event.key];
    if (!action) return;
    event.preventDefault();
    action();
    if (looks[event.key]) draw();
  });
  face.addEventListener("keyup", () => (keyed = stroke("cut")));

  let asking = false;
  let next = null;
  async function hover(place) {
    next = place;
    if (asking) return;
    asking = true;
    while (next) {
      const p_world = worldAt(placed_(), size(), next);
      next = null;
      try {
        const found = await view.ask("probe.at", { p_world, layer: layers.index() });
        const values = found.values.map((one) =>
          one === null ? "" : `${Number(one.toPrecision(5))} ${found.value_unit}`.trim(),
        );
        value.textContent = [...values, found.label ? found.label_name : ""].filter(Boolean).join(" · ");
      } catch {
        value.textContent = "";
      }
    }
    asking = false;
  }
  return { element, plane, show, mark, reset, size, name: () => name };
}
