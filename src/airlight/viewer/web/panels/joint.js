// The editor of joint functions: widgets on a histogram of two variables, and marks of what lies under the pointer.
import { h, fill } from "../dom.js";
import { button, choice, labelled, toggle, words } from "../controls.js";
import { layerPicker } from "../layers.js";
import { stroke } from "../editor/steady.js";
import { probingOf } from "../probing.js";
import { makeFields } from "../joint/fields.js";
import { jointOf } from "../joint/function.js";
import { makePlot } from "../joint/plot.js";
import { fresh, fitted, reordered } from "../joint/shapes.js";
import { attachWidgets, showMarks } from "../joint/widgets.js";

const KINDS = ["triangle", "box", "ellipse", "polygon"];
const COLOURS = [
  [0.093, 0.456, 0.815],
  [0.791, 0.347, 0],
  [0, 0.342, 0.171],
  [0.871, 0.776, 0.055],
  [0.665, 0.112, 0],
  [0.604, 0.191, 0.386],
];

export const panel = {
  title: "Joint function",
  icon: "joint",
  order: 40,
  build(view) {
    const joint = jointOf(view);
    const { layers } = joint;
    const plot = makePlot(["marks", "widgets", "handles"], "Joint histogram");
    let details = null; // what the session told of the histogram
    let asked = "";
    let counting = null;
    let chosen = -1;
    let logarithmic = true;
    let probed = null;
    let around = null;
    let visible = false;

    const plain = (axis) => ({ variable: axis.variable, low: axis.low, high: axis.high });
    const axes = () => joint.axes() ?? details?.axes.map(plain) ?? null;
    const named = () =>
      (axes() ?? []).map((axis, n) => ({ label: String(axis.variable), unit: "", ...details?.axes[n], ...axis }));
    const choose = (n) => {
      chosen = n;
      show();
    };
    const put = (n, shape, merge) =>
      joint.setShapes(
        joint.shapes().map((old, m) => (m === n ? shape : old)),
        merge,
      );
    const remove = (n) => {
      chosen = Math.min(n, joint.shapes().length - 2);
      joint.setShapes(joint.shapes().filter((_, m) => m !== n));
      plot.svg.querySelector(".joint-chosen")?.focus();
    };
    const widgets = attachWidgets(plot, { shapes: joint.shapes, axes: named, chosen: () => chosen, choose, put, remove });
    const fields = makeFields((shape, merge) => put(chosen, shape, merge ?? stroke("widget")));

    /** Add a widget; a layer with a function of one variable gets its joint function first. */
    const add = (shape) => {
      if (!axes() || !shape) return;
      const base = joint.is() ? joint.transfer() : (joint.kept().joint ?? { axes: axes(), shapes: [] });
      chosen = base.shapes.length;
      joint.put({ ...base, shapes: [...base.shapes, fitted(shape, base.axes)] });
    };
    const colourOf = (n) => COLOURS[n % COLOURS.length];
    const usual = () => joint.shapes().at(-1)?.extinction ?? Math.LN2 / (2 * voxel());
    const voxel = () => Math.min(...(layers.volume()?.spacing ?? [1]));
    const addKind = async (kind) => {
      await ask(true); // until the axes are known
      if (!axes()) return;
      const at =
        around?.at && joint.is() ? around.at : axes().map((axis, n) => axis.low + (n ? 0.3 : 0.5) * (axis.high - axis.low));
      add(fresh(kind, axes(), at, colourOf(joint.shapes().length), usual()));
    };
    const failed = (error) => view.tell("error", error);
    const propose = button(
      "Automatic proposal",
      async () => {
        propose.disabled = true;
        try {
          const { transfer } = await view.ask("joint.proposal", { layer: layers.index() });
          chosen = 0;
          joint.put(transfer);
        } catch (error) {
          failed(error);
        }
        propose.disabled = false;
      },
      { title: "Widgets at the boundaries between materials" },
    );
    const addAround = async () => {
      await ask(true);
      if (!around || busy) await hereAgain(true);
      if (around?.around) add(around.around);
      else view.tell("error", { where: "widget", what: "needs a place in the volume", remedy: "point at the picture first" });
    };
    const peakHere = button("Peak here", () => add(around?.peak), {
      title: "A widget at the value under the pointer's last place",
    });
    const here = button("Widget here", addAround, { title: "A widget around what lies under the pointer's last place" });
    const addPeak = async () => {
      if (!probed) return;
      const base = joint.is() ? joint.kept().plain : joint.transfer();
      try {
        const { transfer } = await view.ask("joint.peak", {
          p_world: probed.p_world,
          layer: layers.index(),
          base: base?.points ? base : null,
          number: base?.points?.length ?? 0,
        });
        joint.put(transfer);
      } catch (error) {
        failed(error);
      }
    };

    const kind = choice(
      [
        ["plain", "one variable"],
        ["joint", "two or three variables"],
      ],
      "the layer is drawn by a function of",
      (value) => {
        if (value === "joint") joint.toJoint(axes());
        else if (joint.kept().plain) joint.put(joint.kept().plain);
        else view.ops([{ op: "remove", path: layers.path("transfer") }]); // the library chooses one
      },
    );
    const selects = ["across", "up", "third"].map((word, n) =>
      choice([], `variable, ${word}`, (value) => setVariable(n, value)),
    );
    const scale = toggle("logarithmic scale of counts", (value) => {
      logarithmic = value;
      showCounts();
    });
    scale.show(true);
    const counted = h("p", { class: "help", role: "status" }, "");
    const list = h("ol", { class: "joint-list", "aria-label": "Widgets, the last one is drawn above" });
    const content = h(
      "div",
      { class: "joint" },
      layerPicker(view),
      labelled("function of", kind.element),
      plot.element,
      h(
        "div",
        { class: "row joint-variables" },
        selects.map((one) => one.element),
      ),
      labelled("logarithmic", scale.element),
      counted,
      h(
        "div",
        { class: "joint-buttons" },
        KINDS.map((name) => button(`+ ${name}`, () => addKind(name), { "aria-label": `Add a ${name}` })),
      ),
      h("div", { class: "joint-buttons" }, propose, here, peakHere),
      list,
      fields.element,
    );

    const variable = (value) => details.variables.find((one) => String(one) === value);
    async function setVariable(n, value) {
      const wanted = (axes() ?? []).map((axis) => axis.variable);
      if (value === "") wanted.splice(n, 1);
      else {
        const other = wanted.indexOf(variable(value));
        if (other >= 0 && other !== n) wanted[other] = wanted[n] ?? "value"; // they change places
        wanted[n] = variable(value);
      }
      try {
        const found = await view.ask("joint", { layer: layers.index(), variables: wanted });
        const known = new Map((axes() ?? []).map((axis) => [axis.variable, axis]));
        joint.setAxes(found.axes.map((axis) => known.get(axis.variable) ?? plain(axis)));
      } catch (error) {
        failed(error);
      }
    }

    function ask(now = false) {
      const layer = layers.layer();
      if (!(visible || now) || !layer) return;
      const own = joint.axes();
      const key = JSON.stringify([layers.index(), layer.volume, layer.channel, layer.time, own]);
      if (key !== asked) {
        asked = key;
        counting = count(key, own);
      }
      return counting;
    }

    async function count(key, own) {
      counted.textContent = "Counting ...";
      plot.element.classList.add("counting");
      try {
        const found = await view.ask("joint", { layer: layers.index(), ...(own ? { variables: own } : {}) });
        if (asked !== key) return;
        details = found;
        const bytes = (buffer) =>
          ArrayBuffer.isView(buffer)
            ? new Uint8Array(buffer.buffer, buffer.byteOffset, buffer.byteLength)
            : new Uint8Array(buffer);
        details.shades = found.buffers.map(bytes);
        counted.textContent = found.outside ? `${found.outside} samples lie beyond the axes.` : "";
        showCounts();
        show();
        hereAgain();
      } catch (error) {
        counted.textContent = "";
        failed(error);
      }
      if (asked === key) plot.element.classList.remove("counting");
    }

    const showCounts = () => details && plot.show(details.axes, details.shades[logarithmic ? 0 : 1]);
    const row = (n) => {
      const name = h("button", {
        type: "button",
        class: "row-name",
        onclick: () => (choose(n), plot.svg.querySelector(".joint-chosen")?.focus()),
      });
      const swatch = h("span", { class: "joint-swatch", "aria-hidden": "true" });
      const up = button("↑", () => ((chosen = n + 1), joint.setShapes(reordered(joint.shapes(), n, n + 1))), {
        class: "small",
        "aria-label": `Raise widget ${n + 1}`,
        title: "draw above",
      });
      const down = button("↓", () => ((chosen = n - 1), joint.setShapes(reordered(joint.shapes(), n, n - 1))), {
        class: "small",
        "aria-label": `Lower widget ${n + 1}`,
        title: "draw below",
      });
      const drop = button("×", () => remove(n), { class: "small", "aria-label": `Remove widget ${n + 1}`, title: "remove" });
      return { element: h("li", { class: "row" }, swatch, name, up, down, drop), name, swatch, up, down };
    };
    let rows = [];

    function show() {
      const shapes = joint.shapes();
      const ready = Boolean(axes()) && Boolean(details);
      chosen = Math.min(chosen, shapes.length - 1);
      kind.show(joint.is() ? "joint" : "plain");
      if (rows.length !== shapes.length) {
        rows = shapes.map((_, n) => row(n));
        fill(
          list,
          rows.map((one) => one.element),
        );
      }
      rows.forEach((one, n) => {
        const shape = shapes[n];
        const rgb = shape.ramp?.points[0][1] ?? shape.colour;
        one.name.textContent = `${n + 1} ${shape.kind}`;
        one.name.setAttribute("aria-pressed", String(n === chosen));
        one.swatch.style.background = `rgb(${rgb.map((c) => Math.round(255 * Math.min(1, c) ** (1 / 2.2))).join(" ")})`;
        one.up.disabled = n === shapes.length - 1;
        one.down.disabled = n === 0;
      });
      peakHere.disabled = !around?.peak;
      here.disabled = !around?.around;
      if (!ready) return;
      const known = details.variables.map((one) => [
        String(one),
        typeof one === "number" ? `channel ${one}` : one === "second" ? "second derivative" : words(one),
      ]);
      selects.forEach((one, n) => {
        one.put(n === 2 ? [["", "no third"], ...known] : known);
        one.show(String(axes()[n]?.variable ?? ""));
      });
      widgets.show();
      fields.show(shapes[chosen], axes(), {
        axes: named(),
        voxel: voxel(),
        units: layers.volume()?.units,
        third: details.shades[2] && [...details.shades[2]],
      });
      showMarks(plot.layers.marks, axes(), around);
    }

    // -- what lies under the pointer
    let busy = null;
    function hereAgain(now = false) {
      if (!(visible || now) || !probed || !axes()) return null;
      return (busy ??= askHere());
    }
    /** Until the answer is of the place probed last; answers on the way are shown, so that marks follow the pointer. */
    async function askHere() {
      let point;
      do {
        point = probed;
        try {
          around = await view.ask("joint.here", {
            p_world: point.p_world,
            axes: axes().map(plain),
            layer: layers.index(),
            number: joint.shapes().length,
          });
        } catch {
          around = null; // a point that another layer shows
        }
        show();
      } while (probed !== point);
      busy = null;
    }
    probingOf(view);
    view.on("probed", (found) => {
      if (!found.hit) return;
      probed = found;
      if (visible) hereAgain();
      else around = null;
    });
    view.on("widget", addAround);
    view.on("peak", addPeak);

    new IntersectionObserver((entries) => {
      visible = entries.some((entry) => entry.isIntersecting);
      if (visible) ask();
    }).observe(plot.element);
    joint.on(() => {
      show();
      ask();
    });
    show();
    return content;
  },
};
