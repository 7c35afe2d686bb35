// What is seen, in words and letters: where from, how large.
import { basis } from "./view.js";
import { cross, length, minus, unit } from "./vectors.js";

const STEP_LENGTHS = [5, 2, 1];
const UNITS = ["nm", "µm", "mm", "m", "km"];

/** Names of the six directions, +x -x +y -y +z -z: letters, names, words after "from". */
export function directions(anatomical) {
  const letters = anatomical ? ["L", "R", "P", "A", "S", "I"] : ["+x", "−x", "+y", "−y", "+z", "−z"];
  const names = anatomical ? ["left", "right", "posterior", "anterior", "superior", "inferior"] : letters;
  const words = anatomical ? ["the left", "the right", "the back", "the front", "above", "below"] : letters;
  const axis = (n) => [0, 1, 2].map((k) => (k === n >> 1 ? 1 - 2 * (n & 1) : 0));
  return letters.map((letter, n) => ({ letter, name: names[n], word: words[n], direction: axis(n) }));
}

/** What a direction of a cube's face, edge or corner is called: "left posterior". */
export function directionName(direction, anatomical) {
  const all = directions(anatomical);
  return direction.flatMap((x, axis) => (x ? [all[2 * axis + (x < 0)].name] : [])).join(" ");
}

/** Whether the volumes of a state know where the patient's left is. */
export function isAnatomical(view) {
  const volume = view.document()?.scene.layers[0]?.volume;
  return !!view.volumes[typeof volume === "string" ? volume : volume?.file]?.anatomical;
}

/** Unit of length of the first layer, as it is written. */
export function unitOf(view) {
  const volume = view.document()?.scene.layers[0]?.volume;
  const units = view.volumes[typeof volume === "string" ? volume : volume?.file]?.units ?? "";
  return units === "um" ? "µm" : units;
}

/** Where a camera looks from, in words: "from the front, the left and slightly above". */
export function seenFrom(camera, anatomical) {
  const toEye = unit(minus(camera.eye, camera.target));
  const all = directions(anatomical);
  const parts = [0, 1, 2]
    .map((axis) => ({ share: Math.abs(toEye[axis]), word: all[2 * axis + (toEye[axis] < 0)].word }))
    .filter((part) => part.share > 0.12)
    .sort((a, b) => b.share - a.share)
    .map((part) => (part.share < 0.42 ? `slightly ${part.word}` : part.word));
  return `from ${parts.length > 1 ? `${parts.slice(0, -1).join(", ")} and ${parts.at(-1)}` : parts[0]}`;
}

/** A point of the world as it is written, to a tenth of a voxel of a volume or finer. */
export function placeText(p_world, { spacing, units }) {
  const digits = Math.max(0, Math.min(20, 1 + Math.round(-Math.log10(Math.min(...spacing)))));
  return `${p_world.map((x) => x.toFixed(digits)).join(", ")} ${units === "um" ? "µm" : (units ?? "")}`.trim();
}

/** World units from the bottom to the top of the view at the target's depth; null for cameras that look all round. */
export function shownHeight(camera) {
  if (camera?.name === "orthographic") return camera.height;
  if (!camera?.fov_deg) return null;
  return 2 * length(minus(camera.eye, camera.target)) * Math.tan((camera.fov_deg * Math.PI) / 360);
}

/** The greatest of 1, 2, 5, 10, 20 ... that is not above. */
export function roundBelow(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return (STEP_LENGTHS.find((step) => step * power <= most * (1 + 1e-9)) ?? 1) * power;
}

/** A length as it is written, in a unit that makes its number short. */
export function lengthText(amount, units) {
  const n = UNITS.indexOf(units);
  const steps = n < 0 ? 0 : Math.max(-n, Math.min(UNITS.length - 1 - n, Math.floor(Math.log10(amount) / 3 + 1e-9)));
  return `${Number((amount / 1000 ** steps).toPrecision(3))} ${n < 0 ? units : UNITS[n + steps]}`.trim();
}

/** The scale bar of a camera: { px, text, title }, at most so many CSS pixels long; null where there is none. */
export function scaleBar(camera, height_px, most_px, units) {
  const height = shownHeight(camera);
  if (!height || !height_px) return null;
  const amount = roundBelow((most_px * height) / height_px);
  const parallel = camera.name === "orthographic";
  return {
    px: (amount * height_px) / height, text: lengthText(amount, units), parallel,
    title: parallel
      ? "Holds everywhere: rays are parallel"
      : "Holds at the depth of the point that is turned about; what is nearer is larger",
  };
}

/** What readers say of the picture. */
export function described(view, camera) {
  const height = shownHeight(camera);
  const tall = height ? `, ${lengthText(Number(height.toPrecision(2)), unitOf(view))} from bottom to top` : "";
  const rays = camera.name === "orthographic" ? ", parallel rays" : "";
  return `Volume ${view.name || "rendering"}, seen ${seenFrom(camera, isAnatomical(view))}${tall}${rays}`;
}

/** The six faces of a cube as a camera sees them: axes on the face, and whether it is turned to the eye. */
export function facesOf(camera, anatomical) {
  const { right, up, forward } = basis(camera);
  const seen = (p) => [right, up, forward].map((axis) => axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2]);
  return directions(anatomical).map(({ letter, name, direction }, n) => {
    const above = n >> 1 === 2 ? [0, -1, 0] : [0, 0, 1];
    return { letter, name, direction, above, aside: cross(above, direction), turned: seen(direction)[2] < -1e-6, seen };
  });
}

/** The nine parts of a face: { direction, corners } in the world of the cube from -1 to 1. */
export function partsOf({ direction, above, aside }, edge = 0.56) {
  const ends = [-1, -edge, edge, 1];
  const at = (i, j) => [0, 1, 2].map((k) => direction[k] + i * aside[k] + j * above[k]);
  const parts = [];
  for (const i of [0, 1, 2]) {
    for (const j of [0, 1, 2]) {
      const towards = [0, 1, 2].map((k) => direction[k] + (i - 1) * aside[k] + (j - 1) * above[k]);
      const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(([u, v]) => at(ends[u], ends[v]));
      parts.push({ direction: towards, corners });
    }
  }
  return parts;
}
