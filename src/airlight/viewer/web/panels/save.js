// What is seen, as files: pictures of any size, the scene, Python, movies, a page to send.
import { h } from "../dom.js";
import { button, choice, labelled, toggle } from "../controls.js";
import { download } from "../download.js";

const PICTURES = [["png", "PNG"], ["exr", "EXR, floats and depth"], ["npy", "NumPy, floats"], ["depth", "NumPy, depth"]];
const SIZES = [["1", "as in the view"], ["2", "twice as large"], ["4", "four times as large"], ["1920x1080", "1920 x 1080"], ["3840x2160", "3840 x 2160"], ["own", "another"]];
const WAYS = [["turntable", "one turn"], ["bookmarks", "from bookmark to bookmark"], ["time", "all time steps"]];
const MOVIES = [["mp4", "MP4 (H.264)"], ["webm", "WebM (VP9)"], ["gif", "GIF"], ["png", "PNG, animated"]];
const VOXELS = ["64", "96", "128", "192", "256"];

export const panel = {
  title: "Save",
  order: 85,
  build(view) {
    const chosen = { picture: "png", size: "1", movie: "mp4", way: "turntable", voxels: "128", transparent: false, dither: false, refined: false };
    const number = (label, value, max, min = 1) => h("input", { type: "number", class: "number", min, max, value, "aria-label": label });
    const width = number("width in pixels", 1024, 32768);
    const height = number("height in pixels", 1024, 32768);
    const seconds = number("seconds", 6, 600, 0.1);
    const fps = number("frames a second", 30, 120);
    const title = h("input", { type: "text", maxlength: 200, "aria-label": "title of the page" });
    const own = h("span", { class: "vector", hidden: true }, width, height);
    const length = h("span", { class: "vector" }, seconds, fps);
    const status = h("p", { class: "help", role: "status" });
    const select = (name, options, label, after) => {
      const made = choice(options, label, (value) => ((chosen[name] = value), after?.()));
      made.element.value = chosen[name];
      return made.element;
    };
    const check = (name, label) => toggle(label, (value) => (chosen[name] = value)).element;
    const size = () => {
      if (chosen.size === "own") return [width.valueAsNumber, height.valueAsNumber];
      if (chosen.size.includes("x")) return chosen.size.split("x").map(Number);
      return (view.frame()?.size_px ?? view.size_px()).map((n) => Math.round(n * Number(chosen.size)));
    };
    const even = (pair) => pair.map((n) => n - (n % 2));

    const works = [];
    // What was begun before the page was loaded again can be ended, too.
    const cancel = button("Cancel", () => view.ask("save.cancel").catch((error) => view.tell("error", error)));
    const tell = (error) => (status.textContent = [error.where, error.what, error.remedy].filter(Boolean).join(" ") || String(error));
    const busy = (now) => works.forEach((each) => (each.disabled = now));
    const save = (label, what, args) => {
      const made = button(label, async () => {
        busy(true);
        status.textContent = "";
        try {
          const { name, kind, buffers } = await view.ask(what, args());
          download(name, kind, buffers[0]);
          status.textContent = `${name}: ${buffers[0].byteLength.toLocaleString("en")} bytes`;
        } catch (error) {
          tell(error);
        }
        busy(false);
      });
      works.push(made);
      return made;
    };
    const pictures = () => {
      const depth = chosen.picture === "depth";
      return { kind: depth ? "npy" : chosen.picture, depth, size_px: size(), transparent: chosen.transparent, dither: chosen.dither && chosen.picture === "png", refined: chosen.refined };
    };
    const code = (label, use) => button(label, async () => {
      status.textContent = "";
      await view.ask("code").then(use).catch(tell);
    });
    const keep = ({ name, text }) => download(name, "text/x-python", text);
    // Browsers refuse the clipboard to pages that come from another machine without encryption.
    const copy = code("Copy Python", async (found) => {
      await Promise.resolve().then(() => navigator.clipboard.writeText(found.text)).then(() => (status.textContent = "copied"), () => keep(found));
    });
    const python = code("Python", keep);

    return h("div", { class: "save" },
      labelled("picture", select("picture", PICTURES, "kind of picture")),
      labelled("size", select("size", SIZES, "size", () => (own.hidden = chosen.size !== "own"))), own,
      labelled("no background", check("transparent", "no background")),
      labelled("dither", check("dither", "dither"), "Fine noise instead of bands, in PNG"),
      labelled("refined", check("refined", "refined"), "Drawn until its error is that of Quality, however long it takes"),
      h("div", { class: "row" }, save("Save picture", "save.picture", pictures)),
      h("div", { class: "row" }, save("Scene file", "save.scene", () => ({})), python, copy),
      h("p", { class: "help" }, "Both name volumes by the names of their files alone: put them beside these."),
      h("details", {}, h("summary", {}, "Movie"),
        labelled("shows", select("way", WAYS, "what it shows", () => (length.hidden = chosen.way === "bookmarks"))),
        labelled("kind", select("movie", MOVIES, "kind of movie")),
        labelled("seconds, and frames a second", length),
        h("div", { class: "row" }, save("Save movie", "save.movie", () => ({ kind: chosen.movie, way: chosen.way, size_px: even(size()), seconds: seconds.valueAsNumber, fps: fps.valueAsNumber })))),
      h("details", {}, h("summary", {}, "Page to send"),
        labelled("voxels along an axis, at most", select("voxels", VOXELS, "voxels along an axis")),
        labelled("title", title),
        h("div", { class: "row" }, save("Save page", "save.page", () => ({ voxels: Number(chosen.voxels), title: title.value })))),
      h("div", { class: "row" }, cancel), status);
  },
};
