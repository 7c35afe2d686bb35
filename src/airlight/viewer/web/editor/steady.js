// Edits that come faster than pictures: at most one an animation frame, and none before the one before was answered.
const LONGEST_MS = 250;
let strokes = 0;
const stamp = Math.random().toString(36).slice(2, 8);

/** A name for all edits of one drag, so that they are one step of undo. */
export const stroke = (what) => `${what}:${stamp}${++strokes}`;

/** Sends edits of a view, the newest of a stroke in place of those that wait: { put(ops, merge), flush(), pending() }. */
export function steady(view) {
  let waiting = null;
  let flying = 0; // how many were sent and not answered
  let timer = 0;
  let asked = 0;
  const send = () => {
    asked = 0;
    if (!waiting) return;
    view.ops(waiting.ops, waiting.merge);
    waiting = null;
    flying += 1;
    clearTimeout(timer);
    timer = setTimeout(() => ((flying = 0), soon()), LONGEST_MS);
  };
  const soon = () => {
    if (!flying && waiting && !asked) asked = requestAnimationFrame(send);
  };
  const answered = () => {
    flying = Math.max(0, flying - 1);
    if (!flying) clearTimeout(timer);
    soon();
  };
  const flush = () => {
    cancelAnimationFrame(asked);
    send();
  };
  view.on("state", answered);
  view.on("error", answered);
  return {
    put(ops, merge) {
      if (waiting && waiting.merge !== merge) flush();
      waiting = { ops, merge };
      soon();
    },
    flush,
    /** Whether the session has not yet told of all that was put. */
    pending: () => Boolean(waiting) || flying > 0,
  };
}
