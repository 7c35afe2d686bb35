// Handles above the picture that are dragged in the world, or moved by arrow keys.
import { h } from "./dom.js";

const ARROWS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };

/**
 * A handle: at() is its point of the world, dragged(ray, begun) is called with rays of the pointer, stepped(sign) by arrow keys,
 * told() is what readers say. place() puts it where the last picture shows its point.
 */
export function handle(view, { label, at, dragged, stepped, told, shape = "circle" }) {
  const mark = shape === "circle" ? h("circle", { r: 8 }) : h("rect", { x: -7, y: -7, width: 14, height: 14, rx: 2 });
  const element = h("g", { class: "handle", role: "slider", tabindex: 0, "aria-label": label }, h("circle", { class: "reach", r: 22 }), mark);
  let begun = null;
  const ray = (event) => {
    const box = view.canvas.getBoundingClientRect();
    return view.unproject(event.clientX - box.left, event.clientY - box.top);
  };
  element.addEventListener("pointerdown", (event) => {
    event.stopPropagation();
    element.setPointerCapture(event.pointerId);
    begun = { at: at(), ray: ray(event), id: Math.random().toString(36).slice(2) };
  });
  element.addEventListener("pointermove", (event) => {
    if (!begun) return;
    event.stopPropagation();
    dragged(ray(event), begun);
  });
  const end = () => (begun = null);
  element.addEventListener("pointerup", end);
  element.addEventListener("pointercancel", end);
  element.addEventListener("keydown", (event) => {
    if (!(event.key in ARROWS)) return;
    event.preventDefault();
    event.stopPropagation();
    stepped(ARROWS[event.key] * (event.shiftKey ? 0.1 : 1));
  });
  const place = () => {
    const p_px = view.project(at());
    element.toggleAttribute("hidden", !p_px);
    element.style.display = p_px ? "" : "none";
    if (p_px) element.setAttribute("transform", `translate(${p_px[0]} ${p_px[1]})`);
    element.setAttribute("aria-valuetext", told());
    element.setAttribute("aria-valuenow", "0");
  };
  return { element, place };
}
