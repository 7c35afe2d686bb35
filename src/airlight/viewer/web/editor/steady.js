// Edits that come faster than pictures: at most one an animation frame, and none before the one before was answered.
const LONGEST_MS = 250;
let strokes = 0;
const stamp = Math.random().toString(36).slice(2, 8);

/** A name that nothing else has: of all edits of one drag, so that they are one step of undo, or of one edit. */
export const stroke = (what) => `${what}:${stamp}${++strokes}`;

/** Sends edits of a view, the newest of a stroke in place of those that wait: { put(ops, merge), flush(), pending() }. */
export function steady(view) {
  let waiting = null;
  const flying = new Set(); // ids of those that were sent and not answered
  let isHeld = false;
  let timer = 0;
  let asked = 0;
  const send = () => {
    asked = 0;
    if (!waiting) return;
    flying.add(view.ops(waiting.ops, waiting.merge));
    waiting = null;
    isHeld = true;
    clearTimeout(timer);
    timer = setTimeout(letGo, LONGEST_MS);
  };
  const soon = () => {
    if (!isHeld && waiting && !asked) asked = requestAnimationFrame(send);
  };
  const letGo = () => {
    clearTimeout(timer);
    isHeld = false;
    soon();
  };
  const answered = ({ answers }) => {
    if (flying.delete(answers) && !flying.size) letGo();
  };
  // A session that is met again has lost what was on its way.
  const lost = () => {
    flying.clear();
    letGo();
  };
  const flush = () => {
    cancelAnimationFrame(asked);
    send();
  };
  view.on("state", answered);
  view.on("welcome", lost);
  return {
    put(ops, merge) {
      if (waiting && waiting.merge !== merge) flush();
      waiting = { ops, merge };
      soon();
    },
    flush,
    /** Whether the session has not yet told of all that was put. */
    pending: () => Boolean(waiting) || flying.size > 0,
  };
}
