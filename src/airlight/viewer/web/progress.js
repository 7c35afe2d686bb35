// What takes long, and how much of it is done: a bar at the foot of the picture.
import { h } from "./dom.js";

const LONGEST_MS = 20000;

/** The bar of a view; it goes when all is done, or when nothing was heard of it for long. */
export function progressBar(view) {
  const bar = h("progress", { max: 1 });
  const text = h("span", {});
  const element = h("div", { class: "progress", role: "status", hidden: true }, h("label", {}, text, bar));
  let timer;
  const hide = () => (element.hidden = true);
  view.on("progress", ({ what, done, total }) => {
    clearTimeout(timer);
    if (total > 0 && done >= total) return hide();
    text.textContent = total > 0 ? `${what}: ${Math.floor((100 * done) / total)} %` : `${what} …`;
    if (total > 0) bar.value = done / total;
    else bar.removeAttribute("value");
    element.hidden = false;
    timer = setTimeout(hide, LONGEST_MS);
  });
  view.on("error", hide);
  return element;
}
