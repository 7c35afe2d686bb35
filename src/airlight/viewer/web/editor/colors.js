// Colours of points: a word of the screen, "#rrggbb", and how far they glow beyond it.
import { hexOf, linearOf } from "../controls.js";

/** Greatest colour of a medium; 1 is all of the light. */
export const MOST_GLOW = 16;

/** A linear colour as what a colour input shows, and the factor by which it is brighter than that can be. */
export function split(rgb) {
  const glow = Math.max(1, ...rgb);
  return { hex: hexOf(rgb.map((c) => c / glow)), glow };
}

/** The linear colour of both; what was stays as it was where the word says the same. */
export function joined(hex, glow, before = null) {
  if (before) {
    const was = split(before);
    if (was.hex === hex && was.glow === glow) return before;
  }
  return linearOf(hex).map((c) => c * glow);
}

/** What a style sheet calls a linear colour. */
export const cssOf = (rgb) => hexOf(rgb);
