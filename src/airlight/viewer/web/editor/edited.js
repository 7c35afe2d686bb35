// The function that is edited, as it is here and now: what was changed and is not yet told by the session comes first.
import { layersOf } from "../layers.js";
import { steady, stroke } from "./steady.js";
import { asked, targetOf } from "./target.js";

/** What the parts of the editor share; `changed` is called when something else is to be shown, `isBusy` while one drags. */
export function editedOf(view, { changed, isBusy }) {
  const layers = layersOf(view);
  const edits = steady(view);
  let target = targetOf(view);
  let draft = null;
  let isOther = true; // whether the whole function came from elsewhere

  const edited = {
    layers,
    target: () => target,
    transfer: () => draft ?? target.transfer,
    volume: () => layers.volume(),
    lengthUnit: () => (layers.volume()?.units === "um" ? "µm" : layers.volume()?.units || "unit"),
    fail: (error) => view.tell("error", error),
    flush: edits.flush,
    /** An edit of something else of the layer. */
    putBeside: (path, value, merge) => edits.put([{ op: "set", path, value }], merge),
    /** Another function, as part of a stroke. */
    put(next, merge = stroke("function")) {
      draft = next;
      edits.put([{ op: "set", path: target.path, value: next }], merge);
    },
    putPoints: (points, merge = stroke("points")) => edited.put({ ...edited.transfer(), points }, merge),
    /** A function from elsewhere in place of the present one, as one step. */
    take(next, where = target) {
      edits.flush();
      draft = null;
      isOther = true;
      view.edit(where.path, next, stroke("function"));
    },
    /** A function that the library makes. */
    async made(what, more = {}) {
      const found = await view.ask(what, { ...asked(target), ...more }).catch(edited.fail);
      if (found) edited.take(found.transfer);
    },
    /** What the session says holds. */
    settle() {
      if (isBusy()) return;
      draft = null;
      changed();
    },
    /** Look again at what is edited; returns whether the whole function is another. */
    refresh(isAnother = false) {
      target = targetOf(view);
      if (isAnother || !(isBusy() || edits.pending())) draft = null;
      const told = isOther || isAnother;
      isOther = false;
      return told;
    },
  };
  return edited;
}
