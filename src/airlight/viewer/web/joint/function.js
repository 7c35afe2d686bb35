// The joint function of the layer that is edited: what is shown at once, edits of it, and the last function of either kind.
import { layersOf } from "../layers.js";
import { steady, stroke } from "../editor/steady.js";
import { withVariables } from "./shapes.js";

const LONGEST_MS = 2000;

/** Whether plain data are what was sent: the session leaves out what has its default. */
export function agrees(known, sent) {
  if (typeof known !== "object" || known === null) return known === sent;
  if (typeof sent !== "object" || sent === null || known.length !== sent.length) return false;
  return Object.keys(known).every((key) => agrees(known[key], sent[key]));
}

/** The function of a view: { transfer(), is(), kept(), shapes(), axes(), put, setShapes, setAxes, toJoint, on(listener) }. */
export function jointOf(view) {
  const layers = layersOf(view);
  const stream = steady(view);
  const kept = new Map(); // by layer: { joint, plain }
  const listeners = new Set();
  let local = null; // ahead of the session while it answers
  let timer = 0;

  const now = () => local ?? layers.layer()?.transfer ?? null;
  const is = () => Boolean(now()?.axes);
  const own = () => {
    if (!kept.has(layers.index())) kept.set(layers.index(), { joint: null, plain: null });
    return kept.get(layers.index());
  };
  const tell = () => listeners.forEach((listener) => listener());
  const keep = () => {
    const transfer = now();
    if (transfer) own()[transfer.axes ? "joint" : "plain"] = transfer;
  };
  const settle = () => {
    clearTimeout(timer);
    local = null;
    keep();
    tell();
  };
  const put = (transfer, merge = stroke("joint")) => {
    keep();
    local = transfer;
    clearTimeout(timer);
    timer = setTimeout(settle, LONGEST_MS);
    stream.put([{ op: "set", path: layers.path("transfer"), value: transfer }], merge);
    keep();
    tell();
  };
  view.on("state", () => {
    if (!local || agrees(layers.layer()?.transfer, local)) settle();
  });
  view.on("error", settle); // what the session refused goes away
  layers.on(settle);
  keep();
  return {
    layers,
    is,
    transfer: now,
    kept: own,
    shapes: () => (is() ? now().shapes : []),
    axes: () => now()?.axes ?? null,
    put,
    setShapes: (shapes, merge) => put({ ...now(), shapes }, merge),
    /** Other axes; shapes stay where the first two are the same. */
    setAxes(axes) {
      const same = is() && [0, 1].every((n) => now().axes[n].variable === axes[n].variable);
      put({ ...(is() ? now() : {}), axes, shapes: same ? now().shapes.map((shape) => withVariables(shape, axes)) : [] });
    },
    /** Back to the joint function that was, or an empty one of some axes. */
    toJoint: (axes) => is() || put(own().joint ?? { axes, shapes: [] }),
    on: (listener) => listeners.add(listener),
  };
}
