// Channels of a volume: one alone, or a mixture of several, each with a colour, a window and a density.
import { h, fill } from "../dom.js";
import { button, hexOf, labelled, linearOf } from "../controls.js";
import { layersOf } from "../layers.js";
import { domain, mainColour, tinted, windowed } from "../editor/points.js";
import { logSlider } from "../editor/sliders.js";
import { steady, stroke } from "../editor/steady.js";

const MANY = 6;

export const panel = { title: "Channels", order: 12, build };

function build(view) {
  const layers = layersOf(view);
  const edits = steady(view);
  const path = (...keys) => layers.path("transfer", "channels", ...keys);
  const fail = (error) => view.tell("error", error);
  let names = [];
  let known = "";
  let told = "";
  let rows = [];

  const list = h("ul", { class: "list", "aria-label": "Channels" });
  const search = h("input", {
    type: "text",
    placeholder: "search",
    "aria-label": "search channels",
    oninput: () => showRows(),
  });
  const mix = button("Show all channels", () => mixture(null).catch(fail));
  const element = h("div", {}, search, list, mix);

  const number = (channel) => (typeof channel === "string" ? names.indexOf(channel) : channel);

  async function mixture(channels) {
    const { transfer } = await view.ask("channels.mixture", { layer: layers.index(), ...(channels ? { channels } : {}) });
    view.edit(layers.path("transfer"), transfer, stroke("channels"));
  }

  /** A channel that is not in the mixture yet. */
  async function add(channel) {
    const { transfer } = await view.ask("channels.mixture", { layer: layers.index(), channels: [channel] });
    view.ops([{ op: "insert", path: path(layers.parts().length), value: transfer.channels[0] }], stroke("channels"));
  }

  function partRow(n) {
    const part = () => layers.parts()[n];
    const label = () => names[number(part().channel)] ?? `channel ${part().channel}`;
    const seen = h("input", { type: "checkbox", onchange: () => view.edit(path(n, "visible"), seen.checked) });
    let paint = stroke("channel");
    const swatch = h("input", {
      type: "color",
      onchange: () => (paint = stroke("channel")),
      oninput: () =>
        edits.put(
          [{ op: "set", path: path(n, "transfer", "points"), value: tinted(part().transfer.points, linearOf(swatch.value)) }],
          paint,
        ),
    });
    const name = h("button", { type: "button", class: "row-name", onclick: () => layers.choosePart(n) });
    const remove = button("×", () => view.ops([{ op: "remove", path: path(n) }]), { title: "leave out" });
    const density = logSlider({
      label: "density of the channel",
      onchange: (value, merge) => edits.put([{ op: "set", path: path(n, "density"), value }], merge),
    });
    const ends = ["from", "to"].map((word, end) =>
      h("input", {
        type: "number",
        class: "number",
        step: "any",
        "aria-label": `values ${word}`,
        onchange: (event) => {
          const stretch = domain(part().transfer.points).with(end, event.target.valueAsNumber);
          if (!(stretch[1] > stretch[0])) return void showRows();
          view.edit(
            path(n, "transfer"),
            windowed(part().transfer, (stretch[0] + stretch[1]) / 2, stretch[1] - stretch[0]),
            stroke("window"),
          );
        },
      }),
    );
    const more = h(
      "div",
      {},
      labelled("density", density.element),
      labelled(
        "values",
        h(
          "span",
          { class: "numeric" },
          ends[0],
          "to",
          ends[1],
          h("span", { class: "unit" }, layers.volume()?.value_unit ?? ""),
        ),
      ),
    );
    const show = () => {
      const { visible = true, density: dense = 1, transfer } = part();
      const words = label();
      seen.checked = visible;
      seen.setAttribute("aria-label", `show ${words}`);
      swatch.setAttribute("aria-label", `colour of ${words}`);
      if (document.activeElement !== swatch) swatch.value = hexOf(mainColour(transfer.points));
      name.textContent = words;
      name.setAttribute("aria-pressed", String(layers.part() === n));
      name.title = "edit its curve above";
      remove.setAttribute("aria-label", `Leave out ${words}`);
      remove.disabled = layers.parts().length < 2;
      density.show(dense);
      domain(transfer.points).forEach(
        (value, end) => document.activeElement !== ends[end] && (ends[end].value = Number(value.toPrecision(6))),
      );
      more.hidden = layers.part() !== n;
    };
    return { element: h("li", {}, h("div", { class: "line" }, seen, swatch, name, remove), more), show, label };
  }

  function otherRow(channel) {
    const label = () => names[channel] ?? `channel ${channel}`;
    const name = h(
      "button",
      { type: "button", class: "row-name", onclick: () => view.edit(layers.path("channel"), channel) },
      label(),
    );
    const show = () => {
      name.setAttribute("aria-pressed", String(!layers.parts() && number(layers.layer().channel ?? 0) === channel));
      name.disabled = Boolean(layers.parts());
    };
    const more = layers.parts() ? button("Add", () => add(channel).catch(fail), { "aria-label": `Add ${label()}` }) : null;
    return { element: h("li", {}, h("div", { class: "line" }, name, more)), show, label };
  }

  function showRows() {
    const words = search.value.trim().toLowerCase();
    for (const row of rows) {
      row.show();
      row.element.hidden = !row.label().toLowerCase().includes(words);
    }
  }

  function show() {
    const volume = layers.volume();
    const count = volume?.channels ?? 1;
    if (element.parentElement) element.parentElement.hidden = count < 2;
    if (count < 2) return;
    const key = JSON.stringify([layers.index(), layers.layer().volume]);
    if (known !== key) {
      known = key;
      names = [];
      told = "";
      view.ask("channels", { layer: layers.index() }).then((found) => ((names = found.names), (told = ""), show()), fail);
    }
    const parts = layers.parts();
    mix.hidden = Boolean(parts);
    search.hidden = count <= MANY;
    const now = JSON.stringify([key, names.length, parts?.map((part) => part.channel) ?? null]);
    if (now !== told) {
      const inside = new Set((parts ?? []).map((part) => number(part.channel)));
      const rest = Array.from({ length: count }, (_, n) => n).filter((n) => !inside.has(n));
      rows = [...(parts ?? []).map((_, n) => partRow(n)), ...rest.map(otherRow)];
      fill(
        list,
        rows.map((row) => row.element),
      );
      told = now;
    }
    showRows();
  }

  view.on("state", show);
  layers.on(show);
  // The frame of the panel is there a moment later; for one channel it is not shown.
  queueMicrotask(show);
  return element;
}
