// What panels get: the state, edits of it, questions to the session, the picture, and an overlay above it.
import { stroke } from "./editor/steady.js";
import { piled } from "./gestures.js";
import { cross, dot, minus, plus, times, unit } from "./vectors.js";

const CUT = { where: "connection", what: "was cut,", remedy: "and is tried again" };

/** A view on a session over a model. */
export function makeView(model, canvas, overlay) {
  const listeners = new Map();
  const asked = new Map();
  let number = 0;
  let state = null;
  let frame = null;
  let drawn = Promise.resolve();
  let isCut = false;

  const view = {
    model, canvas, overlay, schema: null, volumes: {}, name: "",
    on(name, listener) {
      listeners.set(name, [...(listeners.get(name) ?? []), listener]);
      return () => listeners.set(name, listeners.get(name).filter((other) => other !== listener));
    },
    tell: (name, ...what) => (listeners.get(name) ?? []).forEach((listener) => listener(...what)),
    send: (message, buffers) => model.send(message, undefined, buffers),
    document: () => state?.document,
    state: () => state,
    frame: () => frame,
    at: (path) => path.reduce((data, key) => data?.[key], state?.document),
    edit: (path, value, merge) => view.ops([{ op: "set", path, value }], merge),
    /** Send an edit; returns its id, which the state or the error that answers it has as `answers`. */
    ops(ops, merge) {
      const id = stroke("edit");
      view.send({ type: "edit", id, ops, merge });
      return id;
    },
    undo: () => view.send({ type: "undo" }),
    redo: () => view.send({ type: "redo" }),
    habits: () => state?.habits,
    hand: "orbit", // what a plain drag makes
    gesture(gesture) {
      pile(gesture);
      view.tell("gesture", gesture);
    },
    ask(what, args = {}, buffers) {
      const id = ++number;
      return new Promise((resolve, reject) => {
        asked.set(id, { resolve, reject });
        if (view.send({ type: "ask", id, what, arguments: args }, buffers) !== false) return;
        asked.delete(id);
        reject(CUT);
      });
    },
    size_px: () => [canvas.clientWidth, canvas.clientHeight],
    project: (p_world) => projected(frame?.camera, p_world, view.size_px()),
    unproject: (x, y) => unprojected(frame?.camera, x, y, view.size_px()),
  };

  const pile = piled((message) => view.send(message));
  const handlers = {
    welcome(message) {
      view.schema = message.schema;
      view.tell("welcome", message);
    },
    state(message) {
      state = message;
      view.volumes = message.volumes;
      view.name = message.name;
      view.tell("state", state);
    },
    frame(message, [data]) {
      // In a chain: bitmaps may be decoded out of order.
      drawn = drawn.then(() => show(message, data)).catch((error) => view.tell("error", { what: String(error) }))
        .finally(() => view.send({ type: "ack", frame: message.frame }));
    },
    answer(message, buffers) {
      const waiting = asked.get(message.id);
      asked.delete(message.id);
      if (message.error) waiting?.reject(message.error);
      else waiting?.resolve({ ...message.value, buffers });
    },
    error(message) {
      if (state) view.tell("state", { ...state, answers: message.answers }); // controls go back to what holds
      view.tell("error", message);
    },
    progress: (message) => view.tell("progress", message),
  };

  async function show(message, data) {
    const blob = new Blob([data], { type: `image/${message.kind}` });
    const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
    canvas.getContext("2d").drawImage(bitmap, 0, 0);
    bitmap.close();
    frame = message;
    view.tell("frame", message);
  }

  const cut = () => {
    for (const { reject } of asked.values()) reject(CUT);
    asked.clear();
    if (!isCut) view.tell("error", CUT);
    isCut = true;
  };
  const others = (message) => view.tell(message.type, message);
  const taken = (message, buffers) => (handlers[message.type] ?? others)(message, buffers);
  const heard = Object.entries({ "msg:open": () => (isCut = false), "msg:closed": cut, "msg:custom": taken });
  heard.forEach(([name, listener]) => model.on(name, listener));
  view.end = () => {
    // Models of notebooks outlive their cells.
    heard.forEach(([name, listener]) => model.off?.(name, listener));
    listeners.clear();
    cut();
  };
  return view;
}

// -- cameras, as plain data

/** Unit vectors to the right, up and forward. */
export function basis(camera) {
  const forward = unit(minus(camera.target, camera.eye));
  const right = unit(cross(forward, camera.up));
  return { right, up: cross(right, forward), forward };
}

/** Half of what the view shows from bottom to top, at distance one or in world units. */
function halfHeight(camera) {
  return camera.name === "orthographic" ? camera.height / 2 : Math.tan((camera.fov_deg * Math.PI) / 360);
}

/** Where a point of the world lies in the view, in CSS pixels; null behind the eye. */
export function projected(camera, p_world, [width, height]) {
  if (!camera || !height) return null;
  const { right, up, forward } = basis(camera);
  const way = minus(p_world, camera.eye);
  const depth = camera.name === "orthographic" ? 1 : dot(way, forward);
  if (depth <= 0) return null;
  const scale = height / 2 / (halfHeight(camera) * depth);
  return [width / 2 + dot(way, right) * scale, height / 2 - dot(way, up) * scale];
}

/** The ray of a point of the view in CSS pixels: { origin, direction } in the world. */
export function unprojected(camera, x, y, [width, height]) {
  if (!camera || !height) return null;
  const { right, up, forward } = basis(camera);
  const half = halfHeight(camera);
  const aside = plus(times(right, (half * (2 * x - width)) / height), up, (half * (height - 2 * y)) / height);
  if (camera.name === "orthographic") return { origin: plus(camera.eye, aside), direction: forward };
  return { origin: camera.eye, direction: unit(plus(forward, aside)) };
}
