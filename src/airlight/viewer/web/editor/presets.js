// Presets as small pictures of the scene, drawn from where it is seen when nothing moves; one click takes one.
import { h, fill } from "../dom.js";
import { asked, targetOf } from "./target.js";

const IDLE_MS = 500;
const SIZE_PX = 96;
const AGAIN_MS = 50;
const MOST_ASKED = 200;

/** A grid of presets: { element, show() }. */
export function presetGrid(view, take) {
  const grid = h("div", { class: "tf-presets", role: "group", "aria-label": "Presets" });
  let known = "";
  let wanted = "";
  let drawn = "";
  let idle = 0;
  let turn = 0;
  let cells = [];
  let isSeen = false;

  async function list(target) {
    const { presets } = await view.ask("presets", asked(target));
    cells = presets.map(({ name, summary, transfer }) => {
      const picture = h("canvas", { width: SIZE_PX, height: SIZE_PX, "aria-hidden": "true" });
      const words = name.replace("glow:", "glow ").replaceAll("_", " ");
      const cell = h(
        "button",
        {
          type: "button",
          class: "tf-preset",
          title: summary,
          "aria-label": `${words}: ${summary}`,
          onclick: () => pick(name, transfer).catch((error) => view.tell("error", error)),
        },
        picture,
        h("span", {}, words),
      );
      return { name, picture, cell, isSlow: !transfer };
    });
    fill(
      grid,
      cells.map(({ cell }) => cell),
    );
    drawn = "";
    wait();
  }

  async function pick(name, transfer) {
    const target = targetOf(view);
    const taken = transfer ?? (await view.ask("presets.function", { ...asked(target), name })).transfer;
    take(taken, target);
  }

  // -- pictures

  /** What the pictures depend on: all that is drawn but the function that they replace. */
  function scene() {
    const { path } = targetOf(view);
    const frame = view.frame()?.camera ?? view.document().scene.camera;
    const rest = JSON.stringify(view.document().scene, function (key, value) {
      return key === "camera" || key === "annotations" || (key === path.at(-1) && Boolean(value?.points)) ? undefined : value;
    });
    return JSON.stringify([path, frame, rest]);
  }

  function wait() {
    clearTimeout(idle);
    turn += 1;
    wanted = scene();
    idle = setTimeout(draw, IDLE_MS);
  }

  /** A picture is asked for until it is there: while it is drawn the session answers others. */
  async function pictureOf(name, mine) {
    for (let n = 0; n < MOST_ASKED && mine === turn; n += 1) {
      const found = await view.ask("presets.picture", { ...asked(targetOf(view)), name }).catch(() => null);
      if (!found || found.buffers.length) return found?.buffers[0];
      await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
    }
    return null;
  }

  async function draw() {
    const mine = turn;
    if (!isSeen || wanted === drawn || !cells.length) return;
    for (const { name, picture } of [...cells].sort((a, b) => a.isSlow - b.isSlow)) {
      const data = await pictureOf(name, mine);
      if (mine !== turn) return; // something has moved
      if (!data) continue;
      const bitmap = await createImageBitmap(new Blob([data], { type: "image/jpeg" }));
      picture.getContext("2d").drawImage(bitmap, 0, 0);
      bitmap.close();
    }
    drawn = wanted;
  }

  // A better picture of the same is no reason to begin again.
  view.on("frame", (frame) => {
    show();
    if (frame.final === false || scene() !== wanted) wait();
  });
  const observer = new IntersectionObserver((seen) => {
    isSeen = seen.at(-1).isIntersecting;
    if (isSeen && drawn !== wanted) wait();
  });
  observer.observe(grid);

  /** Presets are made once the first picture is there, and of another channel when that is edited. */
  function show() {
    const target = targetOf(view);
    const now = `${target.key} ${target.part}`;
    if (!view.frame() || !target.transfer || now === known) return;
    known = now;
    list(target).catch((error) => view.tell("error", error));
  }

  return { element: grid, show };
}
