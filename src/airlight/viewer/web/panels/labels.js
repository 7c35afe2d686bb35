// Labels of regions: as many as there are, a page at a time; what is hidden, what stands out, in which colour.
import { h, fill } from "../dom.js";
import { button, hexOf, labelled, linearOf } from "../controls.js";
import { layersOf } from "../layers.js";
import { slider } from "../editor/sliders.js";
import { steady, stroke } from "../editor/steady.js";

const PAGE = 100;
const ROW_PX = 34;
const COARSE_ROW_PX = 48;
const TYPED_MS = 200;

export const panel = { title: "Labels", order: 14, build };

function build(view) {
  const layers = layersOf(view);
  const edits = steady(view);
  const rowPx = globalThis.matchMedia?.("(pointer: coarse)").matches ? COARSE_ROW_PX : ROW_PX;
  const fail = (error) => view.tell("error", error);
  let pages = new Map(); // of rows, by their first place
  let found = 0;
  let total = 0;
  let known = "";
  let chosen = null;
  let typing = 0;

  const labels = () => layers.layer()?.labels ?? null;
  const tall = h("div", { class: "labels-tall" });
  const rows = h("div", { class: "labels-rows", role: "list", "aria-label": "Labels" });
  const scroller = h(
    "div",
    { class: "labels-scroll", tabindex: 0, "aria-label": "Labels", role: "region", onscroll: () => place() },
    tall,
    rows,
  );
  const search = h("input", {
    type: "text",
    placeholder: "search names and numbers",
    "aria-label": "search labels",
    oninput: () => {
      clearTimeout(typing);
      typing = setTimeout(() => ((scroller.scrollTop = 0), again()), TYPED_MS);
    },
  });
  const count = h("span", { class: "help", role: "status" });
  const opacity = slider({
    label: "opacity of the label",
    onchange: (value, merge) => style("opacity", Math.min(1, Math.max(0, value)), merge),
  });
  const own = button("Own colour", () => plainColour());
  const only = button("Only this", () => change("only", [chosen.label]), { title: "hide all others" });
  const one = h("div", {}, labelled("opacity", opacity.element), h("div", { class: "line" }, only, own));
  const oneName = h("strong", {});
  const element = h(
    "div",
    {},
    labelled("search", search),
    count,
    scroller,
    h("div", {}, oneName, one),
    h(
      "div",
      { class: "line" },
      button("Show all", () => change("show")),
      button("Hide all", () => change("hide")),
      button("None stands out", () => change("plain")),
    ),
  );

  // -- edits: labels may be a name alone on the wire

  function put(key, value, merge) {
    const path = layers.path("labels");
    const plain = labels();
    const table = typeof plain === "string" ? { volume: plain } : plain;
    const ops = typeof plain === "string" ? [{ op: "set", path, value: table }] : [];
    const keys = Array.isArray(key) ? key : [key];
    edits.put(
      [
        ...ops,
        value === undefined ? { op: "remove", path: [...path, ...keys] } : { op: "set", path: [...path, ...keys], value },
      ],
      merge ?? stroke("labels"),
    );
  }

  /** What is hidden and what stands out is text of ranges, which the library writes. */
  async function change(what, some) {
    const next = await view
      .ask("labels.shown", { layer: layers.index(), change: what, ...(some ? { labels: some } : {}) })
      .catch(fail);
    if (!next) return;
    const plain = labels();
    const path = layers.path("labels");
    const { hidden, highlighted } = next;
    const table = { ...(typeof plain === "string" ? { volume: plain } : plain), hidden, highlighted };
    view.ops([{ op: "set", path, value: table }], stroke("labels"));
  }

  function style(name, value, merge, row = chosen) {
    const before = labels()?.styles?.[row.label] ?? {};
    // What was drawn in a colour of its own keeps it when only its opacity changes.
    put(["styles", row.label], { ...before, [name]: value }, merge);
  }

  function plainColour() {
    const { colour: _, ...rest } = labels()?.styles?.[chosen.label] ?? {};
    put(["styles", chosen.label], rest);
  }

  // -- rows

  function rowOf(place_) {
    const row = pages.get(Math.floor(place_ / PAGE))?.[place_ % PAGE];
    const element = h("div", { class: "labels-row", role: "listitem", "aria-setsize": found, "aria-posinset": place_ + 1 });
    element.style.height = `${rowPx}px`;
    if (!row) return element;
    const words = row.name || (row.background ? "background" : `label ${row.label}`);
    const swatch = h("input", { type: "color", value: hexOf(row.colour), "aria-label": `colour of ${words}` });
    let paint = stroke("label");
    swatch.addEventListener("input", () => style("colour", linearOf(swatch.value), paint, row));
    swatch.addEventListener("change", () => (paint = stroke("label")));
    fill(
      element,
      h("input", {
        type: "checkbox",
        checked: row.visible,
        "aria-label": `show ${words}`,
        onchange: (event) => change(event.target.checked ? "show" : "hide", [row.label]),
      }),
      swatch,
      h(
        "button",
        { type: "button", class: "row-name", "aria-pressed": String(chosen?.label === row.label), onclick: () => choose(row) },
        row.name ? `${row.label} ${row.name}` : words,
      ),
      button("★", () => change(row.highlighted ? "plain" : "highlight", [row.label]), {
        class: "star",
        "aria-pressed": String(row.highlighted),
        "aria-label": `${words} stands out`,
        title: "let it stand out",
      }),
    );
    return element;
  }

  function choose(row) {
    chosen = row;
    showOne();
    place();
  }
  function showOne() {
    one.parentElement.hidden = !chosen;
    if (!chosen) return;
    oneName.textContent = chosen.name ? `${chosen.label} ${chosen.name}` : `label ${chosen.label}`;
    opacity.show(chosen.opacity);
    own.disabled = !chosen.own;
  }

  let laid = "";
  function place() {
    if (!labels()) return;
    const first = Math.max(0, Math.floor(scroller.scrollTop / rowPx) - 2);
    const last = Math.min(found, first + Math.ceil(scroller.clientHeight / rowPx) + 4);
    for (let page = Math.floor(first / PAGE); page <= Math.floor(Math.max(first, last - 1) / PAGE); page += 1)
      if (!pages.has(page)) fetch_(page);
    const places = Array.from({ length: Math.max(0, last - first) }, (_, n) => first + n);
    const now = JSON.stringify([first, rowPx, chosen?.label, places.map((n) => pages.get(Math.floor(n / PAGE))?.[n % PAGE])]);
    if (now === laid || rows.querySelector("input[type=color]:focus")) return;
    laid = now;
    const at = document.activeElement?.getAttribute?.("aria-label");
    const held = rows.contains(document.activeElement);
    rows.style.transform = `translateY(${first * rowPx}px)`;
    fill(rows, places.map(rowOf));
    if (held) rows.querySelector(`[aria-label="${CSS.escape(at ?? "")}"]`)?.focus({ preventScroll: true });
  }

  const asked = new Set();
  function fetch_(page) {
    const turn = known;
    if (asked.has(page)) return;
    asked.add(page);
    view.ask("labels", { layer: layers.index(), start: page * PAGE, count: PAGE, search: search.value }).then(
      (got) => {
        asked.delete(page);
        if (turn !== known) return;
        ({ found, total } = got);
        pages.set(page, got.rows);
        chosen = got.rows.find((row) => row.label === chosen?.label) ?? chosen;
        tall.style.height = `${found * rowPx}px`;
        count.textContent =
          found === total
            ? `${total.toLocaleString("en")} labels`
            : `${found.toLocaleString("en")} of ${total.toLocaleString("en")} labels`;
        showOne();
        place();
      },
      (error) => (asked.delete(page), fail(error)),
    );
  }

  /** Ask again for the rows that are shown: something of them has changed. */
  function again() {
    const first = Math.floor(Math.max(0, scroller.scrollTop / rowPx) / PAGE);
    const kept = pages.get(first);
    known = JSON.stringify([layers.index(), labels(), layers.layer()?.time, search.value]);
    pages = new Map(kept ? [[first, kept]] : []);
    asked.clear();
    fetch_(first);
  }

  function show() {
    if (element.parentElement) element.parentElement.hidden = !labels();
    if (!labels()) return;
    const now = JSON.stringify([layers.index(), labels(), layers.layer().time, search.value]);
    if (now !== known) again();
  }

  new ResizeObserver(place).observe(scroller);
  view.on("state", show);
  layers.on(show);
  showOne();
  // The frame of the panel is there a moment later; without labels it is not shown.
  queueMicrotask(show);
  return element;
}
