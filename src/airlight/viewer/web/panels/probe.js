// What lies under the pointer, the profile of its ray, and distances and angles between picked points.
import { h, fill } from "../dom.js";
import { button } from "../controls.js";
import { layersOf } from "../layers.js";
import { makeProfile } from "../profile.js";
import { probingOf } from "../probing.js";
import { placeText } from "../seen.js";

const TOOLS = [
  ["", "Turn"],
  ["probe", "Probe"],
  ["distance", "Distance"],
  ["angle", "Angle"],
];
const POINTS = { distance: 2, angle: 3 };
const HINTS = {
  "": "Values under the pointer are shown while it moves over the picture.",
  probe: "A click marks what is under the pointer and draws the profile of its ray.",
  distance: "Click two points.",
  angle: "Click three points: the angle is that at the second.",
};

export const panel = {
  title: "Probe",
  icon: "probe",
  order: 35,
  build(view) {
    const probing = probingOf(view);
    const layers = layersOf(view);
    const above = h("g", { class: "measures" });
    view.overlay.append(above);
    const readout = h("p", { class: "probe-readout", hidden: true, "aria-hidden": "true" });
    view.stage.append(readout);
    const table = h("dl", { class: "probe-table" });
    const hint = h("p", { class: "help" });
    const list = h("ol", { class: "probe-list", "aria-label": "Measurements" });
    const profile = makeProfile(view);
    let measures = [];
    let begun = [];

    const tools = h(
      "div",
      { class: "row", role: "radiogroup", "aria-label": "What a click does" },
      TOOLS.map(([name, word]) =>
        h("button", { type: "button", role: "radio", "data-tool": name, onclick: () => choose(name) }, word),
      ),
    );
    const choose = (name) => {
      begun = [];
      probing.choose(name);
      for (const one of tools.children) one.setAttribute("aria-checked", String(one.dataset.tool === name));
      hint.textContent = HINTS[name];
      draw();
    };
    tools.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const names = TOOLS.map(([name]) => name);
      const next = (names.indexOf(probing.tool()) + step + names.length) % names.length;
      choose(names[next]);
      tools.children[next].focus();
    });

    const showFound = (found) => {
      readout.hidden = !found.hit;
      if (!found.hit) return;
      readout.textContent = valuesOf(found)
        .concat(found.label_name ? [found.label_name] : [])
        .join(" · ");
      fill(
        table,
        rowsOf(found, layers.volumeOf(layers.all()[found.layer])).flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]),
      );
    };
    view.on("probed", showFound);

    probing.on((found, tool) => {
      hint.textContent = found.hit ? HINTS[tool] : "Nothing is shown there.";
      if (!found.hit) return;
      if (tool === "probe") {
        pin(found);
        profile.ask(found);
      } else if (tool in POINTS) {
        begun.push(found.p_world);
        if (begun.length === POINTS[tool]) keep([...measures.map((one) => one.points), begun]);
        if (begun.length === POINTS[tool]) begun = [];
        draw();
      }
    });
    const pins = () => view.document().scene.annotations ?? [];
    const pin = (found) => {
      const value = { kind: "pointer", p_world: found.p_world, label: valuesOf(found)[0] ?? "" };
      view.ops(
        pins().length
          ? [{ op: "insert", path: ["scene", "annotations", pins().length], value }]
          : [{ op: "set", path: ["scene", "annotations"], value: [value] }],
      );
    };
    const unpin = () =>
      view.edit(
        ["scene", "annotations"],
        pins().filter((one) => one.kind !== "pointer"),
      );
    const clear = button("Remove marks", unpin);
    const middle = button("Middle of the view", () => {
      if (!probing.tool()) choose("probe");
      probing.middle();
    });

    async function keep(kept) {
      try {
        measures = (await view.ask("probe.measures", kept ? { kept } : {})).measures;
      } catch (error) {
        view.tell("error", error);
      }
      fill(
        list,
        measures.map((one, n) =>
          h(
            "li",
            { class: "row" },
            h("span", { class: "probe-measure" }, `${one.points.length === 2 ? "Distance" : "Angle"} ${n + 1}: ${one.text}`),
            button("×", () => keep(measures.filter((_, m) => m !== n).map((other) => other.points)), {
              class: "small",
              "aria-label": `Remove measurement ${n + 1}`,
            }),
          ),
        ),
      );
      draw();
    }

    function draw() {
      const lines = measures.map((one) => drawn(view, one.points, one.text));
      fill(above, lines, begun.length ? drawn(view, begun, "") : null, profile.mark());
    }
    profile.on(draw);
    view.on("frame", draw);
    const showPins = () => (clear.disabled = !pins().some((one) => one.kind === "pointer"));
    view.on("state", showPins);
    showPins();
    choose("");
    keep();
    return h("div", { class: "probe" }, tools, hint, table, profile.element, list, h("div", { class: "row" }, middle, clear));
  },
};

const short = (x) => String(Number(x.toPrecision(5)));

/** Values in words, with names where there are several. */
export function valuesOf({ values = [], names, value_unit = "" }) {
  const said = (value) => (value === null ? "empty" : `${short(value)} ${value_unit}`.trim());
  return values.map((value, n) => (values.length > 1 ? `${names[n]} ${said(value)}` : said(value)));
}

function rowsOf(found, volume) {
  const place = (p) => p.map((x) => x.toFixed(2)).join(", ");
  return [
    ...(found.values ?? []).map((_, n) => [found.names[n], valuesOf({ ...found, values: [found.values[n]] })[0]]),
    found.gradient !== undefined && ["gradient", `${short(found.gradient)} ${found.gradient_unit}`],
    found.label_name !== undefined && ["label", `${found.label}: ${found.label_name}`],
    ["position", volume ? placeText(found.p_world, volume) : place(found.p_world)],
    found.voxel && ["voxel", `${found.voxel.join(", ")} (${place(found.p_index)})`],
    found.t_world !== undefined && [found.faint ? "mean depth" : "depth", `${short(found.t_world)} ${found.units ?? ""}`],
  ].filter(Boolean);
}

/** Points joined by lines, with a text beside the last line (or beside the corner of an angle). */
function drawn(view, points, text) {
  const places = points.map((p) => view.project(p));
  if (places.some((place) => !place)) return null;
  const corner = places[Math.min(1, places.length - 1)];
  const from = places.length === 2 ? places[0] : corner;
  const [x, y] = [(from[0] + corner[0]) / 2 + 8, (from[1] + corner[1]) / 2 - 8];
  return h(
    "g",
    {},
    h("polyline", { points: places.map((p) => p.map((c) => c.toFixed(1)).join(",")).join(" ") }),
    places.map(([px, py]) => h("circle", { cx: px.toFixed(1), cy: py.toFixed(1), r: 4 })),
    text && h("text", { x: x.toFixed(1), y: y.toFixed(1) }, text),
  );
}
