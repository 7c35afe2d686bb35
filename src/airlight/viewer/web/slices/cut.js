// The corner of the volume towards the eye that is cut away at the cross-hair: one clip among those of the scene.
import { steady } from "../editor/steady.js";
import { length, minus } from "../vectors.js";

const MOST_KNOWN = 256;

/** The clip that cuts away the corner of a volume between a point and the eye. */
export function corner(point, eye, { low_world, high_world }) {
  const size = length(minus(high_world, low_world));
  const toEye = point.map((x, n) => eye[n] >= x);
  return {
    kind: "box",
    keep: "outside",
    low: point.map((x, n) => (toEye[n] ? x : low_world[n] - size)),
    high: point.map((x, n) => (toEye[n] ? high_world[n] + size : x)),
  };
}

const keyOf = ({ low, high }) => JSON.stringify([low, high]);

/** Clips with one of our own in the place of any that we sent before; without a new one those are taken away. */
export function replacedClips(clips, known, clip) {
  const place = clips.findIndex((one) => known.has(keyOf(one)));
  const others = clips.filter((one) => !known.has(keyOf(one)));
  if (clip) others.splice(place < 0 ? others.length : place, 0, clip);
  return others;
}

/** The cut of a view: { put(clip, merge), is() }; what it sends is right whether or not the edit before was answered. */
export function makeCut(view) {
  const stream = steady(view);
  const known = new Set(); // of all that was sent: undo and redo bring any of them back
  const clips = () => view.document().scene.clips ?? [];
  let wanted = false;
  return {
    /** Cut with a clip; null: no more. */
    put(clip, merge) {
      const value = replacedClips(clips(), known, clip);
      wanted = Boolean(clip);
      if (clip) known.add(keyOf(clip));
      for (const key of [...known].slice(0, -MOST_KNOWN)) known.delete(key);
      stream.put([{ op: "set", path: ["scene", "clips"], value }], merge);
    },
    /** Whether the volume is cut, or is about to be. */
    is: () => (stream.pending() ? wanted : clips().some((one) => known.has(keyOf(one)))),
  };
}
