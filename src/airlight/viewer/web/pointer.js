// What pointer, fingers and wheel do above the picture, by the table of bindings that the session gives.
import { bound, modifiersOf, travelSeconds } from "./gestures.js";
import { layersOf } from "./layers.js";
import { probingOf } from "./probing.js";

const BUTTONS = ["left", "middle", "right"];
const WHEEL = 0.0006; // heights of a drag for a pixel of the wheel
const PINCHED = 0.006; // for a pixel of a trackpad's pinch, which browsers send as a wheel with Control
const LINE_PX = 16;
const TWIST_RAD = 0.2; // fingers turn as much without meaning it

/** How two fingers lie: middle, distance and angle. */
export function pairOf([a, b]) {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(dx, dy) || 1, angle: Math.atan2(dy, dx) };
}

/** What two fingers did from one place to the next: { dx, dy } in pixels, the dolly's dy, the turn in radians. */
export function paired(before, now) {
  const turn = now.angle - before.angle;
  return {
    dx: now.x - before.x, dy: now.y - before.y,
    nearer: Math.log(before.apart / now.apart) / 2,
    turn: turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI)),
  };
}

/** Heights of a drag that a wheel event stands for. */
export function wheeled(event, height) {
  const delta = event.deltaY || (event.shiftKey ? event.deltaX : 0);
  const px = delta * [1, LINE_PX, height][event.deltaMode];
  return Math.max(-0.25, Math.min(0.25, px * (event.ctrlKey ? PINCHED : WHEEL)));
}

/** Send gestures of the pointer above the picture; returns what ends it. */
export function attachPointer(view) {
  const element = view.canvas;
  const down = new Map();
  let stroke = 0;
  let twisted = 0;
  const entry = (name, modifiers) => bound(view.schema?.bindings, "pointer", name, modifiers, view.habits()?.turning);
  const at = (x, y) => {
    const box = element.getBoundingClientRect();
    return [(x - box.left - box.width / 2) / box.height, (y - box.top - box.height / 2) / box.height];
  };

  const begin = (event) => {
    const button = event.pointerType === "touch" ? "touch" : BUTTONS[event.button];
    const found = entry(button, modifiersOf(event)) ?? entry("left", modifiersOf(event));
    // What the hand is set to takes the place of the plain left button, and of one finger.
    const plain = found && !found.modifier && (found.pointer === "left" || found.pointer === "touch");
    const kind = plain && view.hand !== "orbit" ? view.hand : found?.kind;
    if (down.size === 0) stroke += 1;
    element.classList.add("pointed"); // the ring of the focus is for those who use keys
    down.set(event.pointerId, { x: event.clientX, y: event.clientY, kind, touch: event.pointerType === "touch" });
    twisted = 0;
    try {
      element.setPointerCapture(event.pointerId);
    } catch {
      // A pointer that is gone already.
    }
  };
  const move = (event) => {
    view.tell("pointer", event);
    const last = down.get(event.pointerId);
    if (!last) return;
    const now = { ...last, x: event.clientX, y: event.clientY };
    const height = element.clientHeight;
    if (down.size === 1 && last.kind) {
      const gesture = { kind: last.kind, dx: (now.x - last.x) / height, dy: (now.y - last.y) / height, stroke };
      if (last.kind === "window") gesture.layer = layersOf(view).index();
      view.gesture(gesture);
    } else if (down.size === 2) {
      const before = pairOf([...down.values()]);
      down.set(event.pointerId, now);
      together(before, pairOf([...down.values()]), height);
    }
    down.set(event.pointerId, now);
  };
  const together = (before, now, height) => {
    const { dx, dy, nearer, turn } = paired(before, now);
    twisted += turn;
    view.gesture({ kind: entry("two", [])?.kind, dx: dx / height, dy: dy / height, stroke });
    view.gesture({ kind: entry("pinch", [])?.kind, dy: nearer, at: at(now.x, now.y), stroke });
    if (Math.abs(twisted) > TWIST_RAD) view.gesture({ kind: entry("twist", [])?.kind, dx: turn / Math.PI, stroke });
  };
  const end = (event) => down.delete(event.pointerId);
  const wheel = (event) => {
    // In a page that scrolls, a picture that nobody has chosen lets it.
    if (!element.closest("#airlight") && !element.matches(":focus") && !event.ctrlKey) return;
    event.preventDefault();
    const dy = wheeled(event, element.clientHeight);
    const found = entry("wheel", event.shiftKey ? ["Shift"] : []);
    if (found && dy) view.gesture({ kind: found.kind, dy, at: at(event.clientX, event.clientY) });
  };
  const twice = (event) => {
    if (entry("double", [])?.kind !== "aim" || probingOf(view).tool()) return; // two clicks with a tool are two clicks
    const place = at(event.clientX, event.clientY);
    view.ask("aim", { at: place, seconds: travelSeconds() })
      .then((told) => view.tell("said", told.hit ? "Turns about this point." : "Nothing is shown there."))
      .catch((error) => view.tell("error", error));
  };
  const menu = (event) => event.preventDefault();
  const attached = Object.entries({
    pointerdown: begin, pointermove: move, pointerup: end, pointercancel: end, lostpointercapture: end,
    pointerleave: (event) => view.tell("pointer", event), wheel, dblclick: twice, contextmenu: menu,
  });
  attached.forEach(([name, listener]) => element.addEventListener(name, listener, { passive: false }));
  return () => attached.forEach(([name, listener]) => element.removeEventListener(name, listener));
}
