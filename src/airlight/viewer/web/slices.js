// Slices: planes through a cross-hair that all of them and the volume share; drawn by the session, moved here.
import { h, fill } from "./dom.js";
import { layersOf } from "./layers.js";
import { probingOf } from "./probing.js";
import { stroke } from "./editor/steady.js";
import { makeCell } from "./slices/cell.js";
import { corner, makeCut } from "./slices/cut.js";
import { waysOf } from "./slices/geometry.js";
import { cross, plus, times, unit } from "./vectors.js";

const known = new WeakMap();

/** The slices of a view: { layout(), show(layout), window(), setWindow(ends), point(), move(p), options, on(listener) }. */
export function slicesOf(view) {
  if (!known.has(view)) known.set(view, made(view));
  return known.get(view);
}

/** Values that are black and white at first: most of those that there are, and never the same twice. */
export function usualWindow({ robust_range, range }) {
  const rising = [robust_range, range].find(([low, high]) => high > low);
  return rising ? [...rising] : [range[0], range[0] + (Math.abs(range[0]) || 1)];
}

function made(view) {
  const layers = layersOf(view);
  const listeners = new Set();
  const panes = view.stage.parentElement;
  const options = { hand: "cross", labels: 0.4, clip: false, facing: true };
  let layout = "volume";
  let point = null;
  let window_ = null;
  let normal = null;
  let begun = "";
  let drawn = "";
  let busy = false;
  const waiting = new Set(); // slices that have changed since the question that is under way

  const volume = () => layers.volume();
  const tell = () => listeners.forEach((listener) => listener());
  const middle = () => times(plus(volume().low_world, volume().high_world), 0.5);
  const settle = () => {
    const layer = layers.layer();
    const sampled = JSON.stringify([layer?.volume, layer?.channel, layer?.time, layer?.labels]);
    if (sampled === drawn) return;
    drawn = sampled;
    begin(JSON.stringify(layer?.volume));
    draw();
  };
  /** Another volume: the cross-hair and the window begin anew. */
  const begin = (key) => {
    if (!volume() || key === begun) return;
    begun = key;
    point = middle();
    window_ = usualWindow(volume());
    cells.forEach((cell) => cell.reset());
  };

  const shared = {
    panes,
    layers,
    options,
    volume,
    point: () => point,
    normal: () => normal,
    window: () => window_,
    setWindow: (ends) => setWindow(ends),
    move: (p_world, merge) => move(p_world, merge),
    draw: () => draw(),
  };
  const cells = ["axial", "coronal", "sagittal", "oblique"].map((name) => makeCell(view, shared, name));
  const shown = () => (layout === "volume" ? [] : layout === "both" ? cells.slice(0, 3) : cells);

  const draw = async (some = shown()) => {
    if (busy) return some.forEach((cell) => waiting.add(cell));
    const all = some.filter((cell) => cell.size()[0] > 1 && view.frame()?.camera?.eye);
    all.forEach((cell) => cell.mark());
    drawCross();
    if (!all.length || !point) return;
    busy = true;
    try {
      const planes = all.map((cell) => cell.plane());
      const found = await view.ask("slices", {
        layer: layers.index(),
        window: window_,
        label_opacity: options.labels,
        planes: planes.map((one) => one.asked),
      });
      await Promise.all(all.map((cell, n) => cell.show(found.buffers[n], found.planes[n], planes[n])));
    } catch (error) {
      view.tell("error", error.what ? error : { what: String(error) });
    }
    busy = false;
    const next = shown().filter((cell) => waiting.has(cell));
    waiting.clear();
    if (next.length) draw(next);
  };

  const move = (p_world, merge = stroke("cut")) => {
    const { low_world, high_world } = volume();
    point = p_world.map((x, n) => Math.min(Math.max(x, low_world[n]), high_world[n]));
    if (options.clip) putClip(merge);
    tell();
    draw();
  };

  // -- the volume: a cross-hair above it, and a corner towards the eye that is cut away
  const above = h("g", { class: "slice-cross" });
  view.overlay.append(above);
  const drawCross = () => {
    if (layout !== "both" || !point) return fill(above);
    const { low_world, high_world } = volume();
    fill(
      above,
      [0, 1, 2].map((axis) => {
        const ends = [low_world, high_world].map((end) => view.project(point.map((x, n) => (n === axis ? end[n] : x))));
        return ends.every(Boolean) && h("line", { x1: ends[0][0], y1: ends[0][1], x2: ends[1][0], y2: ends[1][1] });
      }),
    );
  };
  const cut = makeCut(view);
  const putClip = (merge) => cut.put(corner(point, view.frame().camera.eye, volume()), merge);
  const showCut = () => {
    if (options.clip === cut.is()) return;
    options.clip = cut.is();
    tell();
  };

  const obliqueNormal = () => {
    if (normal && !options.facing) return normal;
    const { right, up } = waysOf("oblique", view.frame().camera, null);
    return cross(right, up);
  };
  const setWindow = (ends) => {
    if (!(ends[1] > ends[0])) return;
    window_ = ends;
    tell();
    draw();
  };
  const place = () => {
    panes.dataset.layout = layout;
    cells.forEach((cell) => (cell.element.hidden = !shown().includes(cell)));
    tell();
    draw();
  };
  new ResizeObserver(() => layout !== "volume" && draw()).observe(panes);
  view.on("frame", () => {
    drawCross();
    const turned = options.facing ? shown().filter((cell) => cell.name() === "oblique") : [];
    if (turned.length) draw(turned);
  });
  view.on("state", () => {
    settle();
    showCut();
  });
  layers.on(settle);
  probingOf(view).on((found, tool) => tool === "probe" && found.hit && layout !== "volume" && move(found.p_world));
  settle();
  place();
  return {
    options,
    layout: () => layout,
    show: (name) => ((layout = name), place()),
    window: () => window_,
    setWindow,
    useUsualWindow: () => setWindow(usualWindow(volume())),
    point: () => point,
    move,
    normal: obliqueNormal,
    setNormal: (given) => ((normal = unit(given)), draw()),
    setFacing(value) {
      if (!value) normal = obliqueNormal();
      options.facing = value;
      draw();
    },
    setClip(value) {
      options.clip = value;
      if (value) putClip(stroke("cut"));
      else cut.put(null, stroke("cut"));
    },
    draw,
    on: (listener) => (listeners.add(listener), () => listeners.delete(listener)),
  };
}
