// The curve and what lies behind it, drawn on a canvas, a column of pixels at a time.
import { cssOf } from "./colors.js";
import { evaluate } from "./points.js";

/** Corners [x, share of the height] of the curve: each column, and both sides of each point, so that steps stand upright. */
export function curveLine(points, [low, high], width, height) {
  const value = (x) => low + ((high - low) * x) / width;
  const place = (v) => ((v - low) / (high - low)) * width;
  const corners = Array.from({ length: Math.ceil(width) + 1 }, (_, x) => [x, height.to(evaluate(points, value(x)).extinction)]);
  points.forEach(([v, , extinction], n) => {
    const x = place(v);
    if (x >= 0 && x <= width) corners.push([x, height.to(extinction), n]);
  });
  return corners.sort((a, b) => a[0] - b[0] || (a[2] ?? -1) - (b[2] ?? -1));
}

/** Heights, 0 to 1, of a histogram's columns: the greatest count of the bins that a column meets, of those shown. */
export function histogramColumns(histogram, [low, high], width, log) {
  const { counts, low: first, high: last } = histogram;
  const bin = (last - first) / counts.length;
  const columns = Array.from({ length: Math.ceil(width) }, (_, x) => {
    const begin = Math.floor((low + ((high - low) * x) / width - first) / bin);
    const end = Math.max(begin + 1, Math.ceil((low + ((high - low) * (x + 1)) / width - first) / bin));
    let most = 0;
    for (let n = Math.max(0, begin); n < Math.min(end, counts.length); n += 1) most = Math.max(most, counts[n]);
    return most;
  });
  const share = log ? Math.log1p : (count) => count;
  const top = share(Math.max(1, ...columns));
  return columns.map((count) => share(count) / top);
}

/** Draw histogram, colours and curve on a canvas's context, whose pixels are CSS pixels. */
export function drawCurve(context, { width, height, range, points, axis, histogram, log, marks, ink, faint, accent }) {
  const [low, high] = range;
  context.clearRect(0, 0, width, height);
  if (histogram) {
    context.fillStyle = faint;
    context.globalAlpha = 0.45;
    histogramColumns(histogram, range, width, log).forEach((share, x) =>
      context.fillRect(x, height * (1 - share), 1, height * share),
    );
  }
  context.globalAlpha = 0.85;
  for (let x = 0; x < width; x += 1) {
    const { rgb, extinction } = evaluate(points, low + ((high - low) * (x + 0.5)) / width);
    const tall = height * axis.to(extinction);
    context.fillStyle = cssOf(rgb);
    context.fillRect(x, height - tall, 1, tall);
  }
  context.globalAlpha = 1;
  const line = curveLine(points, range, width, axis);
  for (const [colour, wide] of [
    ["#000", 3],
    [ink, 1.5],
  ]) {
    context.strokeStyle = colour;
    context.globalAlpha = wide > 2 ? 0.35 : 1;
    context.lineWidth = wide;
    context.beginPath();
    line.forEach(([x, share]) => context.lineTo(x, Math.min(height - 1, Math.max(1, height * (1 - share)))));
    context.stroke();
  }
  context.globalAlpha = 1;
  for (const { value, colour, dashed } of marks) {
    const x = ((value - low) / (high - low)) * width;
    if (x < 0 || x > width) continue;
    context.strokeStyle = colour ?? accent;
    context.setLineDash(dashed ? [4, 3] : []);
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, 0);
    context.lineTo(x, height);
    context.stroke();
    context.setLineDash([]);
  }
}

/** Draw the colours alone, as they are at each value. */
export function drawStrip(context, { width, height, range: [low, high], points }) {
  for (let x = 0; x < width; x += 1) {
    context.fillStyle = cssOf(evaluate(points, low + ((high - low) * (x + 0.5)) / width).rgb);
    context.fillRect(x, 0, 1, height);
  }
}
