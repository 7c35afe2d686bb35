// Axes of the editor, and colours in words.

const POWER = 3; // of the axis of extinctions, which gives small ones room

/** Height, 0 to 1, of an extinction on an axis that ends at `top`, and back. */
export const heightOf = (extinction, top) => (Math.max(extinction, 0) / top) ** (1 / POWER);
export const extinctionAt = (height, top) => top * Math.max(height, 0) ** POWER;

const clamped = (x, low, high) => Math.min(Math.max(x, low), high);
const encoded = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);

/** "#rrggbb" of linear light, and back. */
export function hexOf(rgb) {
  return `#${rgb.map((c) => Math.round(255 * encoded(clamped(c, 0, 1))).toString(16).padStart(2, "0")).join("")}`;
}

export const rgbOf = (hex) => [1, 3, 5].map((at) => linear(parseInt(hex.slice(at, at + 2), 16) / 255));

/** Round numbers, about so many, on an axis. */
export function ticks(low, high, about) {
  const rough = (high - low) / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= rough);
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, n) => (first + n) * step);
}

/** A number in about four digits. */
export const inWords = (x) => String(Number(x.toPrecision(4)));
