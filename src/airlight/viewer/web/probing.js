// What lies under the pointer: asked for while it moves over the view and nothing is dragged, one question at a time.
// All who want it listen to view.on("probed", found): what `probe` answers, with x and y in parts of the view.

const CLICK_PX = 4;
const known = new WeakMap();

/** The probing of a view: { last(), tool(), choose(tool), middle(), on(listener) }; its listeners hear of clicks with the tool. */
export function probingOf(view) {
  if (!known.has(view)) known.set(view, made(view));
  return known.get(view);
}

function made(view) {
  const listeners = new Set();
  let tool = "";
  let last = { hit: false };
  let wanted = null; // the newest place of the pointer
  const clicks = []; // all of them, each with the tool that it was made with
  let busy = false;
  let down = null;
  let left = false; // the pointer, since what is asked was wanted

  const placeOf = (event) => {
    const box = view.canvas.getBoundingClientRect();
    const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    return x >= 0 && x <= 1 && y >= 0 && y <= 1 ? { x, y } : null;
  };
  const tell = (found) => {
    last = found;
    view.tell("probed", found);
  };
  async function next() {
    if (busy) return;
    const one = clicks.shift() ?? wanted;
    if (!one) return;
    if (one === wanted) wanted = null;
    const { x, y } = one;
    busy = true;
    try {
      const { buffers: _none, ...found } = await view.ask("probe", { x, y });
      if (one.tool || !left) tell({ ...found, x, y });
      if (one.tool) listeners.forEach((listener) => listener(last, one.tool));
    } catch (error) {
      if (one.tool) view.tell("error", error.what ? error : { what: String(error) });
      tell({ hit: false, x, y, error });
    }
    busy = false;
    next();
  }
  const ask = (place) => {
    if (!place) return;
    left = false;
    wanted = place;
    next();
  };
  const click = (place) => {
    if (!place) return;
    clicks.push({ ...place, tool });
    next();
  };

  view.stage.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]), { capture: true });
  view.stage.addEventListener(
    "pointermove",
    (event) => event.buttons === 0 && event.pointerType !== "touch" && ask(placeOf(event)),
  );
  view.stage.addEventListener("pointerup", (event) => {
    const still = down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < CLICK_PX;
    down = null;
    if (still && event.button === 0 && event.target.closest(".handle, button, a, input") === null) {
      if (tool) click(placeOf(event));
      else if (event.pointerType === "touch") ask(placeOf(event));
    }
  });
  view.stage.addEventListener("pointerleave", (event) => {
    if (event.pointerType === "touch") return; // a finger leaves with each tap
    wanted = null;
    left = true;
    if (last.hit) tell({ hit: false });
  });
  // Where nothing has the focus that is written into or moved by keys, the picture under the pointer takes keys.
  view.stage.addEventListener("pointerenter", (event) => {
    const free = document.activeElement?.matches("body, .airlight button");
    if (free && event.pointerType === "mouse") view.canvas.focus({ preventScroll: true });
  });
  view.on("frame", (frame) => frame.final && last.hit && !busy && ask({ x: last.x, y: last.y }));
  return {
    last: () => last,
    tool: () => tool,
    choose(name) {
      tool = name;
      view.stage.classList.toggle("probing", Boolean(tool));
      view.tell("tool", tool);
    },
    /** What a click in the middle of the view would do, for those who have no pointer. */
    middle: () => click({ x: 0.5, y: 0.5 }),
    on: (listener) => (listeners.add(listener), () => listeners.delete(listener)),
  };
}
