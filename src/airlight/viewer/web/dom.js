// Elements without markup in strings: what comes from files is always text.
const SVG = "http://www.w3.org/2000/svg";
const SVG_NAMES = new Set("svg g path line polyline polygon circle ellipse rect text title defs clipPath linearGradient stop image use".split(" "));

/** An element: h("button", { class: "x", onclick, "aria-label": "Undo" }, "text", child, ...); null children are left out. */
export function h(name, given = {}, ...children) {
  const element = SVG_NAMES.has(name) ? document.createElementNS(SVG, name) : document.createElement(name);
  for (const [key, value] of Object.entries(given)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key === "value" || key === "checked" || key === "disabled" || key === "hidden") element[key] = value;
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** Put other children into an element. */
export function fill(element, ...children) {
  element.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}
