// Lights: a list, and a ball on which directions are dragged.
import { h, fill } from "../dom.js";
import { adder, button, colour, labelled, number, vector } from "../controls.js";
import { dot, plus, times } from "../vectors.js";
import { basis } from "../view.js";

const RADIUS = 60;
const INTENSITY = { name: "intensity", kind: "float", at_least: 0, default: 1 };

export const panel = {
  title: "Lights",
  order: 25,
  build(view) {
    const lights = () => view.document().scene.lights;
    const put = (n, changes, merge) => view.edit(["scene", "lights", n], { ...lights()[n], ...changes }, merge);
    const dots = h("g");
    const ball = h("svg", { class: "ball", viewBox: `${-RADIUS - 10} ${-RADIUS - 10} ${2 * RADIUS + 20} ${2 * RADIUS + 20}`, role: "group", "aria-label": "Directions of the lights" },
      h("title", {}, "Middle: light from the eye; inner circle: from the sides; rim: from behind"),
      h("circle", { class: "rim", r: RADIUS }), h("circle", { class: "side-light", r: RADIUS / 2 }), dots);
    const list = h("ol", { class: "list" });
    const adds = h("div", { class: "row" },
      adder("Directional", () => add({ kind: "directional", to_light: directionOf([-0.25, 0.25], view.frame().camera) })),
      adder("Head", () => add({ kind: "head", intensity: 0.5 })),
      adder("Point", () => add({ kind: "point", position: view.frame().camera.eye })));
    const add = (light) => view.ops([{ op: "insert", path: ["scene", "lights", lights().length], value: light }]);

    let kinds = null;
    let rows = [];
    const show = () => {
      const found = lights();
      const now = found.map((light) => light.kind).join(" ");
      if (now !== kinds) {
        kinds = now;
        rows = found.map((light, n) => rowOf(view, light, n, put));
        fill(list, rows.map((row) => row.element));
        fill(dots, found.map((light, n) => (light.kind === "directional" ? dotOf(view, ball, n, put) : null)));
      }
      rows.forEach((row, n) => row.show(found[n]));
      place();
    };
    const place = () => {
      const camera = view.frame()?.camera;
      if (camera) for (const mark of dots.children) mark.place(camera);
    };
    view.on("state", show);
    view.on("frame", place);
    show();
    return h("div", {}, ball, adds, list);
  },
};

/** Controls of one light. */
function rowOf(view, light, n, put) {
  const tint = colour(`colour of light ${n + 1}`, (rgb) => put(n, { color: rgb }, `light.${n}.color`));
  const strength = number(INTENSITY, (value) => put(n, { intensity: value }, `light.${n}.intensity`));
  const named = { directional: "to_light", point: "position", spot: "position" }[light.kind];
  const where = named && vector({ name: named, kind: "vec3" }, (value) => put(n, { [named]: value }));
  const remove = button("Remove", () => view.ops([{ op: "remove", path: ["scene", "lights", n] }]), { "aria-label": `remove light ${n + 1}` });
  const element = h("li", {}, h("div", { class: "row" }, h("strong", {}, `${n + 1}. ${light.kind}`), tint.element, remove),
    labelled("intensity", strength.element), where && labelled(named.replace("_", " "), where.element));
  const show = (data) => {
    tint.show(data.color);
    strength.show(data.intensity ?? 1);
    where?.show(data[named]);
  };
  return { element, show };
}

// -- the ball: distance from the middle is the angle to the line of sight, 180 degrees at the rim

/** The direction of the world of a place on the ball, in parts of its radius, y up. */
export function directionOf([x, y], camera) {
  const { right, up, forward } = basis(camera);
  const r = Math.hypot(x, y);
  const angle = Math.PI * Math.min(1, r);
  const aside = r ? Math.sin(angle) / r : 0;
  return plus(plus(times(forward, -Math.cos(angle)), right, x * aside), up, y * aside);
}

/** The place on the ball of a direction of the world. */
export function placeOf(direction, camera) {
  const { right, up, forward } = basis(camera);
  const size = Math.hypot(...direction) || 1;
  const [x, y] = [dot(direction, right), dot(direction, up)];
  const aside = Math.hypot(x, y);
  const angle = Math.acos(Math.max(-1, Math.min(1, -dot(direction, forward) / size)));
  return aside ? [(x / aside) * (angle / Math.PI), (y / aside) * (angle / Math.PI)] : [0, angle > 1 ? 1 : 0];
}

/** A place on the ball, or inside its rim where it is beyond: at the rim all places are one direction. */
export const onBall = (place) => times(place, Math.min(1, 0.995 / (Math.hypot(...place) || 1)));

function dotOf(view, ball, n, put) {
  const mark = h("circle", { class: "light", r: 8, role: "slider", tabindex: 0, "aria-label": `direction of light ${n + 1}`, "aria-valuenow": 0 });
  const say = (place, merge) => put(n, { to_light: directionOf(place, view.frame().camera) }, merge);
  let drag = "";
  mark.addEventListener("pointerdown", (event) => {
    mark.setPointerCapture(event.pointerId);
    drag = `light.${n}.${Math.random()}`;
  });
  mark.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const box = ball.getBoundingClientRect();
    const scale = (2 * RADIUS + 20) / box.width / RADIUS;
    say(onBall([(event.clientX - box.left - box.width / 2) * scale, (box.top + box.height / 2 - event.clientY) * scale]), drag);
  });
  const end = () => (drag = "");
  mark.addEventListener("pointerup", end);
  mark.addEventListener("pointercancel", end);
  mark.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!by) return;
    event.preventDefault();
    const at = placeOf(view.at(["scene", "lights", n]).to_light, view.frame().camera);
    say(onBall(at.map((x, m) => x + 0.03 * by[m])), `light.${n}.keys`);
  });
  mark.place = (camera) => {
    const light = view.at(["scene", "lights", n]);
    const [x, y] = placeOf(light.to_light, camera);
    mark.setAttribute("cx", x * RADIUS);
    mark.setAttribute("cy", -y * RADIUS);
    mark.setAttribute("aria-valuetext", `${Math.round(180 * Math.hypot(x, y))} degrees from the line of sight`);
  };
  return mark;
}
