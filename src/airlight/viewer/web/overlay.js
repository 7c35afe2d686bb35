// What is drawn over the picture, by the camera of the last frame: cube, scale bar, cross-hair, a line of figures, words.
import { h } from "./dom.js";
import { orientationCube } from "./cube.js";
import { described, scaleBar, unitOf } from "./seen.js";

const TURNING_MS = 500;
const QUIET_MS = 1200;
const BAR_PX = 170;

/** The line of figures of a frame. */
export function statusText(frame) {
  const [width, height] = frame.drawn_px ?? [];
  const parts = [`${width} × ${height}`];
  if (frame.fps && !frame.final) parts.push(`${Math.round(frame.fps)} fps`);
  if (frame.step) parts.push(`step ${Number(frame.step.toPrecision(2))}`);
  if (frame.refined === false && frame.final) parts.push("refining …");
  return parts.join(", ");
}

/** Put the overlay above the picture; returns { element, said(words) }. */
export function pictureOverlay(view) {
  const cube = orientationCube(view);
  const bar = h("div", { class: "bar" });
  const length = h("span", {});
  const where = h("span", { class: "where" });
  const scale = h("div", { class: "scale", role: "img" }, length, where, bar);
  const status = h("p", { class: "figures", "aria-hidden": "true" });
  const cross = h("svg", { class: "cross", viewBox: "-20 -20 40 40", "aria-hidden": "true" },
    h("path", { d: "M-16 0H-5M5 0H16M0 -16V-5M0 5V16" }));
  const words = h("p", { class: "unseen", role: "status", "aria-live": "polite" });
  const element = h("div", { class: "over" }, cross, scale, status, cube.element, words);
  let turned = 0;
  let quiet = 0;
  let description = "";

  const place = () => {
    const frame = view.frame();
    const camera = frame?.camera;
    const hidden = view.habits()?.hidden ?? [];
    cube.element.toggleAttribute("hidden", hidden.includes("cube") || !camera?.eye);
    cube.show(camera);
    const [width, height] = view.size_px();
    const written = new Set((view.document()?.scene.annotations ?? []).map((one) => one.kind));
    const own = written.has("scale_bar");
    element.classList.toggle("lettered", written.has("orientation"));
    const found = own || hidden.includes("scale") ? null : scaleBar(camera, height, Math.min(BAR_PX, width / 3), unitOf(view));
    scale.hidden = !found;
    if (found) {
      bar.style.width = `${found.px}px`;
      length.textContent = `${found.text} `;
      where.textContent = found.parallel ? "" : "at the target";
      scale.title = found.title;
      scale.setAttribute("aria-label", `Scale bar: ${found.text}. ${found.title}.`);
    }
    status.hidden = hidden.includes("status") || !frame;
    if (frame) status.textContent = statusText(frame);
  };
  const describe = () => {
    const camera = view.frame()?.camera;
    if (!camera?.eye) return;
    const told = described(view, camera);
    if (told === description) return;
    // Readers hear of it once nothing moves, and not of the first picture, which they come to by themselves.
    if (description) words.textContent = told;
    description = told;
    view.canvas.setAttribute("aria-label", told);
  };
  view.on("frame", () => {
    place();
    clearTimeout(quiet);
    quiet = setTimeout(describe, QUIET_MS);
  });
  view.on("state", place);
  view.on("said", (told) => (words.textContent = told));
  view.on("gesture", (gesture) => {
    if (!["orbit", "turntable", "trackball", "roll"].includes(gesture.kind)) return;
    cross.classList.add("shown");
    clearTimeout(turned);
    turned = setTimeout(() => cross.classList.remove("shown"), TURNING_MS);
  });
  new ResizeObserver(place).observe(view.canvas);
  return element;
}
