// Pointers, wheel and keys to gestures: { kind, dx, dy } in parts of the view's height.

const WHEEL = 1 / 1500; // of a height a pixel of the wheel
const LINE_PX = 30;
const KEY = 0.04;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const NEARER = { "+": -1, "=": -1, PageUp: -1, "-": 1, PageDown: 1 };
const BUTTONS = ["orbit", "pan", "dolly"];

/** The gesture of a key; null for others. */
export function gestureOfKey({ key, shiftKey }) {
  if (key in KEYS) {
    const [dx, dy] = KEYS[key].map((way) => way * KEY);
    return { kind: shiftKey ? "pan" : "orbit", dx, dy };
  }
  return key in NEARER ? { kind: "dolly", dx: 0, dy: NEARER[key] * KEY } : null;
}

/** Gestures of fingers that moved from some places to others: one turns, two move and go nearer by how they part. */
export function gesturesOfFingers(before, after, height) {
  const middle = (places) => [0, 1].map((n) => places.reduce((sum, p) => sum + p[n], 0) / places.length);
  const [[x, y], [u, v]] = [middle(before), middle(after)];
  const [dx, dy] = [(u - x) / height, (v - y) / height];
  if (before.length === 1) return [{ kind: "orbit", dx, dy }];
  const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
  return [{ kind: "pan", dx, dy }, { kind: "dolly", dx: 0, dy: Math.log(apart(before) / apart(after)) / 2 }];
}

/** Call `made` with the gestures on an element, and `reset` where the first view is wanted. */
export function listen(element, made, reset) {
  const pointers = new Map();
  const place = (event) => [event.clientX, event.clientY];
  let kind = "orbit";
  element.addEventListener("pointerdown", (event) => {
    if (pointers.size >= 2) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    kind = event.shiftKey ? "pan" : BUTTONS[event.button] ?? "orbit";
  });
  element.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    const before = [...pointers.values()];
    pointers.set(event.pointerId, place(event));
    const gestures = gesturesOfFingers(before, [...pointers.values()], element.clientHeight);
    gestures.forEach((one) => made(before.length === 1 ? { ...one, kind } : one));
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    element.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("dblclick", reset);
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    made({ kind: "dolly", dx: 0, dy: event.deltaY * (event.deltaMode ? LINE_PX : 1) * WHEEL });
  }, { passive: false });
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const gesture = gestureOfKey(event);
    if (event.key === "Home") reset();
    else if (gesture) made(gesture);
    else return;
    event.preventDefault();
  });
}
