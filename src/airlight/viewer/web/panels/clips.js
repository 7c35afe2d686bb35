// Clip planes, boxes and spheres, with handles in the view.
import { h, fill } from "../dom.js";
import { adder, button, choice, labelled, number, toggle, vector } from "../controls.js";
import { handle } from "../handles.js";
import { dot, length, minus, nearestAlong, onSphere, placed, plus, times, unit } from "../vectors.js";
import { basis } from "../view.js";

const STEP = 0.01;
const SIGNS = [[0, -1], [0, 1], [1, -1], [1, 1], [2, -1], [2, 1]];

export const panel = {
  title: "Clips",
  order: 20,
  build(view) {
    const list = h("ol", { class: "list" });
    const above = h("g", { class: "clips" });
    view.overlay.append(above);
    const clips = () => view.document().scene.clips ?? [];
    const extent = () => bounds(view);
    const put = (n, changes, merge) => view.edit(["scene", "clips", n], { ...clips()[n], ...changes }, merge);
    const add = (clip) => view.ops(clips().length
      ? [{ op: "insert", path: ["scene", "clips", clips().length], value: clip }]
      : [{ op: "set", path: ["scene", "clips"], value: [clip] }]);
    const middle = () => times(plus(extent().low, extent().high), 0.5);

    const adds = h("div", { class: "row" },
      adder("Plane", () => add({ kind: "plane", point: middle(), normal: basis(view.frame().camera).forward })),
      adder("Box", () => add({ kind: "box", low: shrunk(extent(), 0), high: shrunk(extent(), 1) })),
      adder("Sphere", () => add({ kind: "sphere", center: middle(), radius: 0.35 * Math.min(...minus(extent().high, extent().low)) })));

    let kinds = "";
    let rows = [];
    let handles = [];
    const show = () => {
      const found = clips();
      const now = found.map((clip) => clip.kind).join(" ");
      if (now !== kinds) {
        kinds = now;
        rows = found.map((clip, n) => rowOf(view, clip, n, put));
        fill(list, rows.map((row) => row.element));
        handles = found.flatMap((clip, n) => handlesOf(view, clip.kind, n, put, extent));
        fill(above, handles.map((one) => one.element));
      }
      rows.forEach((row, n) => row.show(found[n]));
      place();
    };
    const place = () => view.frame() && clips().length && handles.forEach((one) => one.place());
    view.on("state", show);
    view.on("frame", place);
    show();
    return h("div", {}, adds, list);
  },
};

/** Controls of one clip. */
function rowOf(view, clip, n, put) {
  const keep = choice(["inside", "outside"], `clip ${n + 1} keeps`, (value) => put(n, { keep: value }));
  const capped = toggle(`clip ${n + 1}: the cut is closed`, (value) => put(n, { capped: value }));
  const parameters = {
    plane: ["point", "normal"], box: ["low", "high"], sphere: ["center", "radius"], mesh: [],
  }[clip.kind].map((name) => {
    const parameter = { name, kind: name === "radius" ? "float" : "vec3", unit: name === "normal" ? "" : view.volumes.v0?.units };
    const made = (name === "radius" ? number : vector)(parameter, (value) => put(n, { [name]: value }, `clip.${n}.${name}`));
    return { name, made };
  });
  const element = h("li", { class: "clip" },
    h("div", { class: "row" }, h("strong", {}, `${n + 1}. ${clip.kind}`), button("Turn over", () => put(n, turned(view.at(["scene", "clips", n]))), { "aria-label": `clip ${n + 1}: keep the other side` }),
      button("Remove", () => view.ops([{ op: "remove", path: ["scene", "clips", n] }]), { "aria-label": `remove clip ${n + 1}` })),
    labelled("keeps", keep.element), labelled("closed", capped.element, "Show what is cut as a face"),
    parameters.map(({ name, made }) => labelled(name, made.element)));
  const show = (data) => {
    keep.show(data.keep ?? "inside");
    capped.show(data.capped);
    parameters.forEach(({ name, made }) => made.show(data[name]));
  };
  return { element, show };
}

const turned = (clip) => (clip.kind === "plane" ? { normal: times(clip.normal, -1) } : { keep: clip.keep === "outside" ? "inside" : "outside" });

/** Lowest and highest corner of all volumes. */
function bounds(view) {
  const all = Object.values(view.volumes);
  const by = (pick, name) => [0, 1, 2].map((axis) => pick(...all.map((volume) => volume[name][axis])));
  return { low: by(Math.min, "low_world"), high: by(Math.max, "high_world") };
}

const shrunk = ({ low, high }, end) => low.map((from, n) => (end ? high[n] - 0.1 * (high[n] - from) : from + 0.1 * (high[n] - from)));

/** Handles of the clip of a number: of a plane its place and its direction, of a box its faces, of a sphere both. */
function handlesOf(view, kind, n, put, extent) {
  const clip = () => view.at(["scene", "clips", n]);
  const size = () => length(minus(extent().high, extent().low));
  const told = (value) => `${value.map((x) => Number(x.toPrecision(4))).join(", ")} ${view.volumes.v0?.units ?? ""}`;
  const along = (name, direction, from) => (ray, begun) => {
    const moved = nearestAlong(begun.at, direction(), ray);
    const first = nearestAlong(begun.at, direction(), begun.ray);
    if (moved !== null && first !== null) from(plus(begun.at, direction(), moved - first), `clip.${n}.${name}.${begun.id}`);
  };
  if (kind === "plane") {
    const normal = () => unit(clip().normal);
    const reach = () => 0.15 * size();
    const point = (p_world, merge) => put(n, { point: p_world }, merge);
    return [
      handle(view, { label: `plane ${n + 1}: place`, at: () => clip().point, dragged: along("point", normal, point),
        stepped: (by) => point(plus(clip().point, normal(), by * STEP * size()), `clip.${n}.point`), told: () => told(clip().point) }),
      handle(view, { label: `plane ${n + 1}: direction`, shape: "square", at: () => plus(clip().point, normal(), reach()),
        dragged: (ray, begun) => put(n, { normal: unit(minus(onSphere(clip().point, reach(), ray), clip().point)) }, `clip.${n}.normal.${begun.id}`),
        stepped: (by) => put(n, { normal: unit(plus(normal(), basis(view.frame().camera).right, 0.05 * by)) }, `clip.${n}.normal`), told: () => told(normal()) }),
    ];
  }
  if (kind === "sphere") {
    const right = () => basis(view.frame().camera).right;
    const rim = (p_world, merge) => put(n, { radius: Math.max(1e-6 * size(), dot(minus(p_world, clip().center), right())) }, merge);
    return [
      handle(view, { label: `sphere ${n + 1}: centre`, at: () => clip().center,
        dragged: (ray, begun) => put(n, { center: inPlane(view, begun.at, ray, begun.ray) }, `clip.${n}.center.${begun.id}`),
        stepped: (by) => put(n, { center: plus(clip().center, right(), by * STEP * size()) }, `clip.${n}.center`), told: () => told(clip().center) }),
      handle(view, { label: `sphere ${n + 1}: radius`, shape: "square", at: () => plus(clip().center, right(), clip().radius), dragged: along("radius", right, rim),
        stepped: (by) => rim(plus(clip().center, right(), clip().radius + by * STEP * size()), `clip.${n}.radius`), told: () => told([clip().radius]) }),
    ];
  }
  if (kind !== "box") return [];
  return SIGNS.map(([axis, sign]) => {
    const matrix = () => clip().world_from_box ?? [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]];
    const end = sign > 0 ? "high" : "low";
    const centre = () => [0, 1, 2].map((m) => (m === axis ? clip()[end][m] : (clip().low[m] + clip().high[m]) / 2));
    const column = () => [0, 1, 2].map((row) => matrix()[row][axis]);
    const face = (coordinate, merge) => {
      const other = clip()[sign > 0 ? "low" : "high"][axis];
      const least = 1e-3 * size() / (length(column()) || 1);
      const inside = sign > 0 ? Math.max(coordinate, other + least) : Math.min(coordinate, other - least);
      put(n, { [end]: clip()[end].map((x, m) => (m === axis ? inside : x)) }, merge);
    };
    const moved = (p_world, merge) => face(clip()[end][axis] + dot(minus(p_world, placed(matrix(), centre())), unit(column())) / length(column()), merge);
    return handle(view, { label: `box ${n + 1}: ${end} ${"xyz"[axis]}`, at: () => placed(matrix(), centre()), dragged: along(`${end}${axis}`, () => unit(column()), moved),
      stepped: (by) => face(clip()[end][axis] + (by * STEP * size()) / length(column()), `clip.${n}.${end}${axis}`), told: () => told([clip()[end][axis]]) });
  });
}

/** Where a point goes that is dragged in the plane that faces the eye. */
function inPlane(view, p_world, ray, from) {
  const { forward } = basis(view.frame().camera);
  const hit = ({ origin, direction }) => plus(origin, direction, dot(minus(p_world, origin), forward) / dot(direction, forward));
  return plus(p_world, minus(hit(ray), hit(from)));
}
