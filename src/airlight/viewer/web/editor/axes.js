// Axes of the editor: values in data units to pixels and back, and heights by which small opacities can be told apart.

const POWER = 3;
const LOG_FLOOR = 1e-4;
/** Greatest opacity that can be dragged or typed: 1 would need an endless extinction. */
export const MOST_OPACITY = 0.9999;

/** From a share of the greatest height to a share of the axis, and back; 0 stays 0 on each. */
export const SCALES = {
  linear: { to: (share) => share, from: (y) => y },
  power: { to: (share) => share ** (1 / POWER), from: (y) => y ** POWER },
  log: {
    to: (share) => Math.log1p(share / LOG_FLOOR) / Math.log1p(1 / LOG_FLOOR),
    from: (y) => LOG_FLOOR * Math.expm1(y * Math.log1p(1 / LOG_FLOOR)),
  },
};

/** Opacity over a length in world units of an extinction per world unit, and back: 1 - exp(-extinction length). */
export const opacityOf = (extinction, length) => -Math.expm1(-extinction * length);
export const extinctionOf = (opacity, length) => -Math.log1p(-Math.min(Math.max(opacity, 0), MOST_OPACITY)) / length;

/** Heights of a plot: extinctions up to a top, or opacities over a length up to 1, on a scale. */
export function heights({ quantity, scale, top, length }) {
  const { to, from } = SCALES[scale];
  const opacity = quantity === "opacity";
  const shareOf = (extinction) => (opacity ? opacityOf(extinction, length) : extinction / top);
  return {
    /** Share of the axis, 0 to 1, of an extinction; what is higher is shown at the top. */
    to: (extinction) => to(Math.min(1, Math.max(0, shareOf(extinction)))),
    /** Extinction at a share of the axis. */
    from: (y) => {
      const share = from(Math.min(1, Math.max(0, y)));
      return opacity ? extinctionOf(share, length) : share * top;
    },
    /** What stands beside the axis: [share of the axis, number]. */
    ticks: () => {
      const most = opacity ? 1 : top;
      if (scale === "linear") return ticks(0, most, 4).map((value) => [value / most, value]);
      return [0, 0.001, 0.01, 0.1, 1]
        .map((share) => [to(share), share * most])
        .filter(([y], n, all) => n === 0 || y - all[n - 1][0] > 0.08);
    },
  };
}

/** The stretch of values [low, high] that holds all that is given, with a little room. */
export function holding(stretches, room = 0.03) {
  const low = Math.min(...stretches.map(([a]) => a));
  const high = Math.max(...stretches.map(([, b]) => b));
  const span = high - low || Math.abs(low) || 1;
  return [low - room * span, high + room * span];
}

/** A stretch zoomed by a factor about a value, and kept within limits. */
export function zoomed([low, high], about, factor, limits) {
  const least = 1e-6 * (limits[1] - limits[0]);
  const span = Math.max(least, (high - low) * factor);
  const share = (about - low) / (high - low);
  return within([about - share * span, about + (1 - share) * span], limits);
}

/** A stretch moved by a way, and kept within limits. */
export const panned = ([low, high], by, limits) => within([low + by, high + by], limits);

function within([low, high], [first, last]) {
  if (high - low >= last - first) return [first, last];
  const by = Math.max(0, first - low) + Math.min(0, last - high);
  return [low + by, high + by];
}

/** Even places between two ends at 1, 2 or 5 times a power of ten, about so many. */
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= raw * (1 - 1e-9));
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, n) => rounded((first + n) * step, step));
}

/** The least round number that is no less. */
export function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return rounded(power * [1, 1.5, 2, 3, 5, 7, 10].find((factor) => factor * power >= value * (1 - 1e-9)), power / 10);
}

/** A number to the digits that a step has, without the rest that binary leaves. */
export function rounded(value, step) {
  const digits = Math.max(0, Math.min(15, -Math.floor(Math.log10(step) + 1e-9)));
  const power = 10 ** Math.floor(Math.log10(step) + 1e-9);
  return digits > 0 ? Number(value.toFixed(digits)) : Math.round(value / power) * power;
}

/** Words for a number: as short as its step allows. */
export function said(value, digits = 4) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4)
    return value
      .toExponential(2)
      .replace(/\.?0+e/, "e")
      .replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}
