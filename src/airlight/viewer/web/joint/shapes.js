// Shapes of joint functions as the plain data they are saved as: outlines, handles, hits, and changes that keep them valid.
// Coordinates are in the axes' own units; turns are as seen on a square plot, as in the library.

const LEAST = 0.005; // of an axis: no smaller, so that it can be taken hold of
const ROUND = 64; // corners that draw an ellipse

const span = (axis) => axis.high - axis.low;
const clamp = (x, low, high) => Math.min(Math.max(x, low), Math.max(low, high));
const within = (x, axis) => clamp(x, axis.low, axis.high);
const replaced = (list, n, value) => list.map((old, m) => (m === n ? value : old));
const beginOf = (triangle) => triangle.low ?? triangle.tip ?? 0;

/** Lowest and highest coordinate along both axes of the plot: [[low, high], [low, high]]. */
export function bounds(shape, axes) {
  if (shape.kind === "box") return [0, 1].map((n) => [shape.low[n], shape.high[n]]);
  if (shape.kind === "triangle")
    return [
      [shape.value - shape.half_width, shape.value + shape.half_width],
      [beginOf(shape), shape.top],
    ];
  if (shape.kind === "ellipse") return reach(shape, axes).map((r, n) => [shape.centre[n] - r, shape.centre[n] + r]);
  return [0, 1].map((n) => [Math.min(...shape.vertices.map((v) => v[n])), Math.max(...shape.vertices.map((v) => v[n]))]);
}

/** How far an ellipse reaches along both axes of the plot. */
function reach({ radii, angle_rad = 0 }, axes) {
  const [c, s] = [Math.cos(angle_rad), Math.sin(angle_rad)];
  const [a, b] = [0, 1].map((n) => radii[n] / span(axes[n]));
  return [Math.hypot(a * c, b * s) * span(axes[0]), Math.hypot(a * s, b * c) * span(axes[1])];
}

/** A point of an ellipse: x and y in radii along its own axes. */
function onEllipse({ centre, radii, angle_rad = 0 }, axes, x, y) {
  const [c, s] = [Math.cos(angle_rad), Math.sin(angle_rad)];
  const [a, b] = [(x * radii[0]) / span(axes[0]), (y * radii[1]) / span(axes[1])];
  return [centre[0] + (a * c - b * s) * span(axes[0]), centre[1] + (a * s + b * c) * span(axes[1])];
}

/** The other way round: coordinates of a point along an ellipse's own axes, in parts of the plot. */
function turnedBack({ centre, angle_rad = 0 }, axes, point) {
  const [c, s] = [Math.cos(angle_rad), Math.sin(angle_rad)];
  const [x, y] = [0, 1].map((n) => (point[n] - centre[n]) / span(axes[n]));
  return [c * x + s * y, c * y - s * x];
}

/** The outline as points; `share` of 1 is the border, less lies inside. */
export function outline(shape, axes, share = 1) {
  if (shape.kind === "polygon") return shape.vertices;
  if (shape.kind === "ellipse") {
    const turns = Array.from({ length: ROUND }, (_, n) => (2 * Math.PI * n) / ROUND);
    return turns.map((turn) => onEllipse(shape, axes, share * Math.cos(turn), share * Math.sin(turn)));
  }
  if (shape.kind === "box") {
    const [[a, b], [c, d]] = bounds(shape, axes).map(([low, high]) => [
      0.5 * (low + high - share * (high - low)),
      0.5 * (low + high + share * (high - low)),
    ]);
    return [
      [a, c],
      [b, c],
      [b, d],
      [a, d],
    ];
  }
  const { value, half_width, top, tip = 0 } = shape;
  const begin = beginOf(shape);
  const half = (at) => (share * half_width * (at - tip)) / (top - tip);
  return [
    [value - half(begin), begin],
    [value + half(begin), begin],
    [value + half(top), top],
    [value - half(top), top],
  ];
}

/** Part of the border within which the weight is 1; null where it falls from the middle on, or where no line shows it. */
export function core(shape) {
  if (shape.kind === "ellipse") return 1 / 3; // one standard deviation
  const edge = shape.edge ?? (shape.kind === "triangle" ? 1 : 0);
  return shape.kind === "polygon" || edge <= 0.02 || edge >= 0.98 ? null : 1 - edge;
}

/** Whether a point lies in a shape. */
export function holds(shape, axes, [x, y]) {
  const line = outline(shape, axes);
  return line.reduce((inside, [ax, ay], n) => {
    const [bx, by] = line[(n + 1) % line.length];
    return ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax) ? !inside : inside;
  }, false);
}

/** Number of the uppermost shape at a point, -1 where there is none: the last one is drawn above. */
export const hit = (shapes, axes, point) => shapes.findLastIndex((shape) => holds(shape, axes, point));

/** Handles of a shape: { name, label, at: [first, second], round: whether it turns }. */
export function handles(shape, axes) {
  if (shape.kind === "box") {
    const ways = [
      ["low", "low"],
      ["high", "low"],
      ["high", "high"],
      ["low", "high"],
    ];
    return ways.map(([x, y]) => ({ name: `${x} ${y}`, label: `corner, ${x} and ${y}`, at: [shape[x][0], shape[y][1]] }));
  }
  if (shape.kind === "triangle") {
    const { value, half_width, top, tip = 0 } = shape;
    const begin = beginOf(shape);
    return [
      { name: "tip", label: "tip", at: [value, within(tip, axes[1])] },
      ...(begin > tip || shape.low !== undefined ? [{ name: "low", label: "lower end", at: [value, begin] }] : []),
      { name: "left", label: "upper left", at: [value - half_width, top] },
      { name: "right", label: "upper right", at: [value + half_width, top] },
    ];
  }
  if (shape.kind === "ellipse") {
    return [
      { name: "first", label: "first radius", at: onEllipse(shape, axes, 1, 0) },
      { name: "second", label: "second radius", at: onEllipse(shape, axes, 0, 1) },
      { name: "turn", label: "turn", at: onEllipse(shape, axes, 0.72, 0.72), round: true },
    ];
  }
  return shape.vertices.map((at, n) => ({ name: `vertex ${n}`, label: `corner ${n + 1}`, at }));
}

/** The shape after one of its handles was put at a point. */
export function pulled(shape, axes, name, point) {
  const at = point.map((x, n) => within(x, axes[n]));
  return carried(shape, fitted(PULLED[shape.kind](shape, axes, name, at), axes), axes);
}

const PULLED = {
  box(shape, axes, name, at) {
    const ends = { low: [...shape.low], high: [...shape.high] };
    name.split(" ").forEach((end, n) => {
      const least = LEAST * span(axes[n]);
      ends[end][n] = end === "low" ? Math.min(at[n], shape.high[n] - least) : Math.max(at[n], shape.low[n] + least);
    });
    return { ...shape, ...ends };
  },
  triangle(shape, axes, name, [x, y]) {
    const least = LEAST * span(axes[1]);
    const begin = beginOf(shape);
    if (name === "tip") return { ...shape, value: x, tip: Math.min(y, shape.low ?? Infinity, shape.top - least) };
    if (name === "low") return { ...shape, low: clamp(y, Math.max(shape.tip ?? 0, axes[1].low), shape.top - least) };
    const half = Math.max((name === "left" ? -1 : 1) * (x - shape.value), LEAST * span(axes[0]));
    return { ...shape, half_width: half, top: Math.max(y, begin + least) };
  },
  ellipse(shape, axes, name, at) {
    const [a, b] = turnedBack(shape, axes, at);
    if (name === "turn") {
      // The handle lies on the diagonal of the radii: what turns is measured from there.
      const from = Math.atan2(shape.radii[1] / span(axes[1]), shape.radii[0] / span(axes[0]));
      const angle = (shape.angle_rad ?? 0) + Math.atan2(b, a) - from;
      return { ...shape, angle_rad: Math.atan2(Math.sin(angle), Math.cos(angle)) };
    }
    const n = name === "first" ? 0 : 1;
    return { ...shape, radii: replaced(shape.radii, n, Math.max(Math.abs(n ? b : a), LEAST) * span(axes[n])) };
  },
  polygon: (shape, axes, name, at) => ({ ...shape, vertices: replaced(shape.vertices, Number(name.slice(7)), at) }),
};

/** The shape moved as a whole, as far as the axes let it. */
export function shifted(shape, axes, by) {
  const [x, y] = bounds(shape, axes).map(([low, high], n) => clamp(by[n], axes[n].low - low, axes[n].high - high));
  const both = (point) => replaced(replaced(point, 0, point[0] + x), 1, point[1] + y);
  let moved;
  if (shape.kind === "box") moved = { ...shape, low: both(shape.low), high: both(shape.high) };
  else if (shape.kind === "ellipse") moved = { ...shape, centre: both(shape.centre) };
  else if (shape.kind === "polygon") moved = { ...shape, vertices: shape.vertices.map(both) };
  else {
    const low = shape.low === undefined ? {} : { low: shape.low + y };
    moved = { ...shape, value: shape.value + x, top: shape.top + y, tip: (shape.tip ?? 0) + y, ...low };
  }
  return carried(shape, fitted(moved, axes), axes);
}

/** The shape made valid: inside of the axes, and of some size. */
export function fitted(shape, axes) {
  if (shape.kind === "box") {
    const pairs = axes.slice(0, shape.low.length).map((axis, n) => {
      const low = clamp(shape.low[n], axis.low, axis.high - LEAST * span(axis));
      return [low, clamp(shape.high[n], low + LEAST * span(axis), axis.high)];
    });
    return { ...shape, low: pairs.map((p) => p[0]), high: pairs.map((p) => p[1]) };
  }
  if (shape.kind === "ellipse") {
    const most = Math.max(1, ...reach(shape, axes).map((r, n) => (2 * r) / span(axes[n])));
    const radii = shape.radii.map((r, n) => (n < 2 ? r / most : clamp(r, LEAST * span(axes[n]), span(axes[n]) / 2)));
    const around = [...reach({ ...shape, radii }, axes), ...radii.slice(2)];
    return { ...shape, radii, centre: shape.centre.map((c, n) => clamp(c, axes[n].low + around[n], axes[n].high - around[n])) };
  }
  if (shape.kind === "polygon") {
    const vertices = shape.vertices.map((v) => v.map((x, n) => within(x, axes[n])));
    const flat = [0, 1].filter((n) => vertices.every((v) => v[n] === vertices[0][n]));
    // All on one line: one corner gives way.
    flat.forEach((n) => {
      const up = vertices[0][n] + LEAST * span(axes[n]);
      vertices[0] = replaced(vertices[0], n, up <= axes[n].high ? up : vertices[0][n] - LEAST * span(axes[n]));
    });
    return { ...shape, vertices };
  }
  const value = clamp(shape.value, axes[0].low + LEAST * span(axes[0]), axes[0].high - LEAST * span(axes[0]));
  const half_width = clamp(shape.half_width, LEAST * span(axes[0]), Math.min(value - axes[0].low, axes[0].high - value));
  const top = clamp(shape.top, axes[1].low + LEAST * span(axes[1]), axes[1].high);
  const least = LEAST * span(axes[1]);
  const tip = Math.min(shape.tip ?? 0, top - least);
  const low =
    shape.low === undefined && tip >= axes[1].low
      ? undefined
      : clamp(shape.low ?? tip, Math.max(tip, axes[1].low), top - least);
  const { low: _low, tip: _tip, ...rest } = shape;
  return { ...rest, value, half_width, top, ...(tip ? { tip } : {}), ...(low === undefined ? {} : { low }) };
}

/** The changed shape with its colour ramp carried along: where it began and ended in the old bounds it does in the new ones. */
function carried(old, changed, axes) {
  if (!old.ramp || old.ramp.axis > 1) return changed;
  const [low, high] = bounds(old, axes)[old.ramp.axis];
  const [to, end] = bounds(changed, axes)[old.ramp.axis];
  const points = old.ramp.points.map(([at, rgb]) => [to + ((at - low) / (high - low)) * (end - to), rgb]);
  return { ...changed, ramp: { ...old.ramp, points } };
}

/** A new shape of a kind, about a fifth of the plot wide, at a point. */
export function fresh(kind, axes, at, colour, extinction) {
  const look = { colour, extinction };
  const [w, v] = [0, 1].map((n) => 0.1 * span(axes[n]));
  const [x, y] = at;
  const made = {
    box: () => ({ kind, low: [x - w, y - v], high: [x + w, y + v], edge: 0.5 }),
    triangle: () => ({
      kind,
      value: x,
      half_width: w,
      top: y + v,
      low: Math.max(axes[1].low, y - v),
      tip: Math.min(axes[1].low, y - v),
    }),
    ellipse: () => ({ kind, centre: [x, y], radii: [w, v] }),
    polygon: () => ({
      kind,
      vertices: [
        [x - w, y - v],
        [x + w, y - v],
        [x + 0.6 * w, y + v],
        [x - 0.6 * w, y + v],
      ],
    }),
  }[kind]();
  return withVariables(fitted({ ...made, ...look }, axes), axes);
}

// -- the third axis

/** Interval of a shape along the third axis. */
export function thirdOf(shape, axes) {
  if (shape.kind === "box") return [shape.low[2], shape.high[2]];
  if (shape.kind === "ellipse") return [shape.centre[2] - shape.radii[2], shape.centre[2] + shape.radii[2]];
  return shape.third ?? [axes[2].low, axes[2].high];
}

/** The shape with another interval along the third axis, in any order. */
export function withThird(shape, axes, ends) {
  const least = LEAST * span(axes[2]);
  const [a, b] = ends.map((x) => within(x, axes[2])).sort((p, q) => p - q);
  const low = Math.min(a, axes[2].high - least);
  const high = Math.max(b, low + least);
  if (shape.kind === "box") return { ...shape, low: replaced(shape.low, 2, low), high: replaced(shape.high, 2, high) };
  if (shape.kind === "ellipse")
    return { ...shape, centre: replaced(shape.centre, 2, (low + high) / 2), radii: replaced(shape.radii, 2, (high - low) / 2) };
  return { ...shape, third: [low, high] };
}

/** The shape for as many variables as there are axes: over the whole of a third one that it did not have. */
export function withVariables(shape, axes) {
  const { third: _third, ...flat } = shape;
  const three = axes.length === 3;
  const ramp = shape.ramp && shape.ramp.axis >= axes.length ? { ramp: undefined } : {};
  const put = (list, extra) => (three ? [...list.slice(0, 2), list[2] ?? extra] : list.slice(0, 2));
  if (shape.kind === "box")
    return { ...flat, ...ramp, low: put(shape.low, axes[2]?.low), high: put(shape.high, axes[2]?.high) };
  if (shape.kind === "ellipse") {
    const [middle, half] = three ? [(axes[2].low + axes[2].high) / 2, span(axes[2]) / 2] : [];
    return { ...flat, ...ramp, centre: put(shape.centre, middle), radii: put(shape.radii, half) };
  }
  return three ? { ...shape, ...ramp } : { ...flat, ...ramp };
}

// -- polygons

/** A polygon with one corner more, in the middle of its longest side. */
export function withCorner(shape, axes) {
  const { vertices } = shape;
  const next = (n) => vertices[(n + 1) % vertices.length];
  const sides = vertices.map((v, n) => Math.hypot(...v.map((x, m) => (next(n)[m] - x) / span(axes[m]))));
  const n = sides.indexOf(Math.max(...sides));
  const middle = vertices[n].map((x, m) => (x + next(n)[m]) / 2);
  return { ...shape, vertices: [...vertices.slice(0, n + 1), middle, ...vertices.slice(n + 1)] };
}

/** A polygon without one of its corners; itself where it has but three. */
export function withoutCorner(shape, axes, n) {
  return shape.vertices.length <= 3 ? shape : fitted({ ...shape, vertices: shape.vertices.filter((_, m) => m !== n) }, axes);
}

/** A list with one entry at another place. */
export function reordered(list, from, to) {
  const rest = list.filter((_, n) => n !== from);
  const place = clamp(to, 0, rest.length);
  return [...rest.slice(0, place), list[from], ...rest.slice(place)];
}
