// What the last picture took, pass by pass.
import { h, fill } from "../dom.js";

export const panel = {
  title: "Statistics",
  order: 90,
  build(view) {
    const body = h("tbody");
    const row = (name, value) => h("tr", {}, h("th", { scope: "row" }, name), h("td", {}, value));
    const rounded = (value) => (typeof value !== "number" ? spoken(value) : Number.isInteger(value) ? value.toLocaleString("en") : String(Number(value.toPrecision(4))));
    const spoken = (value) => (typeof value === "boolean" ? (value ? "yes" : "no") : String(value ?? ""));
    const rows = (data, before = "") => Object.entries(data ?? {}).flatMap(([name, value]) => {
      const full = before ? `${before}: ${name}` : name;
      if (value && typeof value === "object" && (!Array.isArray(value) || value.some((part) => typeof part === "object"))) return rows(value, full);
      if (Array.isArray(value) && !value.length) return [];
      return [row(full.replaceAll("_", " "), Array.isArray(value) ? value.map(rounded).join(", ") : rounded(value))];
    });
    const show = (frame) => {
      if (!frame || !body.closest("details")?.open) return;
      const { drawn_px, size_px, step, ms, fps, kind, stats } = frame;
      fill(body, rows({ size: size_px.join(" x "), drawn: drawn_px.join(" x "), step, milliseconds: ms, "frames a second": fps ?? "", encoded: kind }), rows(stats));
    };
    view.on("frame", show);
    queueMicrotask(() => body.closest("details")?.addEventListener("toggle", () => show(view.frame())));
    return h("table", { class: "statistics" }, body);
  },
};
