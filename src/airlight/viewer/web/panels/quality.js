// How the picture is drawn at rest: driver, step, tolerance, skipping.
import { h } from "../dom.js";
import { choice, labelled, number, stage } from "../controls.js";

const STEP = { name: "step", kind: "float", above: 0, up_to: 4, unit: "voxel", default: 1 };
const TOLERANCE = { name: "tolerance", kind: "float", at_least: 0.00001, below: 1, default: 0.004, optional: true };

export const panel = {
  title: "Quality",
  order: 70,
  build(view) {
    const put = (value, name) => view.ops([value === null ? { op: "remove", path: ["render", name] } : { op: "set", path: ["render", name], value }], name);
    const driver = stage(view, "driver", "driver", (value, parameter) => view.edit(["render", "driver"], value, parameter && `driver.${parameter}`));
    const step = number(STEP, put);
    const tolerance = number(TOLERANCE, put);
    const skip = choice(["auto", "none", "blocks", "geometry"], "skipping of what is empty", (value) => put(value, "skip"));
    const show = () => {
      const { render } = view.document();
      driver.show(render.driver);
      step.show(render.step);
      tolerance.show(render.tolerance ?? null);
      skip.show(render.skip);
    };
    view.on("state", show);
    show();
    return h("div", {},
      labelled("step", step.element, "Distance between samples, once nothing moves"),
      labelled("refined to an error of", tolerance.element, "Greatest error of each pixel and colour, of 1; empty: the picture stays at its step"),
      labelled("skipping", skip.element, "Never changes the picture"),
      labelled("driver", driver.element, view.schema.slots.driver.help));
  },
};
