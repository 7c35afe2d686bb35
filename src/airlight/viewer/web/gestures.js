// Gestures on their way to the session: what makes them, and one message an animation frame.
const SUMS = ["dx", "dy", "dz"];
const MOVES = new Set(["orbit", "turntable", "trackball", "look", "pan", "dolly", "roll", "fly", "fov", "window"]);

/** The entry of the table of bindings for a button, finger or key; the most particular of those that fit. */
export function bound(bindings, source, name, modifiers, turning) {
  const held = new Set(modifiers);
  if (held.has("Meta")) held.add("Control");
  const fits = (entry) =>
    entry[source] === name && (entry.turning ?? turning) === turning && (!entry.modifier || held.has(entry.modifier));
  const rank = (entry) => !!entry.modifier + !!entry.turning;
  return (bindings ?? []).filter(fits).reduce((best, entry) => (best && rank(best) >= rank(entry) ? best : entry), null);
}

/** Modifiers that an event tells. */
export const modifiersOf = (event) =>
  [["Shift", event.shiftKey], ["Control", event.ctrlKey], ["Alt", event.altKey], ["Meta", event.metaKey]]
    .filter(([, held]) => held)
    .map(([name]) => name);

/** What waits, with one more gesture: moves of one kind and stroke add up as long as nothing else came between. */
export function joined(waiting, gesture) {
  const since = waiting.findLastIndex((other) => !MOVES.has(other.kind)) + 1;
  const n = MOVES.has(gesture.kind)
    ? waiting.findIndex((other, at) => at >= since && other.kind === gesture.kind && other.stroke === gesture.stroke)
    : -1;
  if (n < 0) return [...waiting, gesture];
  const sums = Object.fromEntries(SUMS.filter((name) => waiting[n][name] || gesture[name])
    .map((name) => [name, (waiting[n][name] ?? 0) + (gesture[name] ?? 0)]));
  return waiting.with(n, { ...waiting[n], ...gesture, ...sums });
}

/** A function that takes gestures and sends those of one animation frame together. */
export function piled(send, later = (call) => requestAnimationFrame(call)) {
  let waiting = [];
  const go = () => {
    const all = waiting;
    waiting = [];
    send(all.length === 1 ? { type: "gesture", ...all[0] } : { type: "gesture", all });
  };
  return (gesture) => {
    if (!waiting.length) later(go);
    waiting = joined(waiting, gesture);
  };
}

/** Seconds that a camera travels: none where the user wants little motion. */
export const travelSeconds = () => (globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches ? 0 : 0.35);
