// The orientation cube: drag turns, a click on a face, an edge or a corner looks from there.
import { h } from "./dom.js";
import { travelSeconds } from "./gestures.js";
import { directionName, facesOf, isAnatomical, partsOf } from "./seen.js";

const SIZE = 40; // of half an edge, in its own units
const DRAG_PX = 4;

const written = (p_px) => p_px.map((x) => x.toFixed(2)).join(",");

/** The cube of a view: { element, show(camera) }. */
export function orientationCube(view) {
  const word = h("text", { class: "cube-word", x: 0, y: 92 });
  const board = h("svg", { class: "cube", viewBox: "-76 -76 152 176", role: "group", "aria-label": "Orientation" });
  let faces = [];
  let anatomicalNow = null;

  const look = (direction) => view.gesture({ kind: "view", direction, seconds: travelSeconds() });
  const build = (camera, anatomical) => {
    faces = facesOf(camera, anatomical).map((face) => {
      const parts = partsOf(face).map((part) => {
        const middle = part.direction.every((x, k) => x === face.direction[k]);
        const key = part.direction.join(" ");
        return { ...part, element: h("polygon", { class: middle ? "part" : "part edge", "data-key": key }) };
      });
      const letter = h("text", { class: "letter", x: 0, y: 0 }, face.letter);
      const named = `View from ${anatomical ? face.name : face.letter}`;
      const shapes = parts.map((part) => part.element);
      const element = h("g", { class: "face", role: "button", tabindex: 0, "aria-label": named }, shapes, letter);
      element.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        look(face.direction);
      });
      element.addEventListener("focus", () => say(face.direction.join(" ")));
      element.addEventListener("blur", () => say(null));
      return { element, letter, parts };
    });
    board.replaceChildren(...faces.map((face) => face.element), word);
  };

  const show = (camera) => {
    if (!camera?.eye) return;
    const anatomical = isAnatomical(view);
    if (anatomicalNow !== anatomical) build(camera, anatomical);
    anatomicalNow = anatomical;
    facesOf(camera, anatomical).forEach((face, n) => {
      const { element, letter, parts } = faces[n];
      element.classList.toggle("away", !face.turned);
      if (!face.turned) return;
      const px = (p) => face.seen(p).slice(0, 2).map((x, k) => (k ? -SIZE : SIZE) * x);
      for (const part of parts) {
        part.element.setAttribute("points", part.corners.map((corner) => written(px(corner))).join(" "));
      }
      const [middle, aside, above] = [face.direction, face.aside, face.above].map(px);
      const matrix = [...aside, -above[0], -above[1], ...middle].map((x, k) => (k < 4 ? x / SIZE : x).toFixed(3));
      letter.setAttribute("transform", `matrix(${matrix.join(" ")})`);
    });
  };

  let begun = null;
  const say = (key) => (word.textContent = key ? directionName(key.split(" ").map(Number), anatomicalNow) : "");
  const mark = (key) => {
    say(key);
    board.querySelectorAll(".part").forEach((part) => part.classList.toggle("near", !!key && part.dataset.key === key));
  };
  board.addEventListener("pointerdown", (event) => {
    event.stopPropagation();
    begun = { x: event.clientX, y: event.clientY, key: event.target.dataset?.key ?? centreOf(event.target), moved: false };
    board.setPointerCapture(event.pointerId);
  });
  board.addEventListener("pointermove", (event) => {
    if (!begun) return mark(event.target.dataset?.key ?? centreOf(event.target));
    const [dx, dy] = [event.clientX - begun.x, event.clientY - begun.y];
    if (!begun.moved && Math.hypot(dx, dy) < DRAG_PX) return;
    Object.assign(begun, { x: event.clientX, y: event.clientY, moved: true });
    const height = board.clientHeight;
    const kind = view.habits()?.turning === "trackball" ? "trackball" : "turntable";
    view.gesture({ kind, dx: dx / height, dy: dy / height });
  });
  board.addEventListener("pointerup", () => {
    if (begun && !begun.moved && begun.key) look(begun.key.split(" ").map(Number));
    begun = null;
  });
  board.addEventListener("pointercancel", () => (begun = null));
  board.addEventListener("pointerleave", () => mark(null));
  return { element: board, show };
}

/** Letters are clicked for the middle of their face. */
const centreOf = (element) => element.closest?.(".face")?.querySelector(".part:not(.edge)")?.dataset.key;
