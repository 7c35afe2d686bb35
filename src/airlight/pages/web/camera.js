// Cameras and what drags make of them. A camera is { name, eye, target, up, fov_deg | height }.

const TURN = Math.PI; // of a drag over the whole height
const MOST_HEIGHT = 1.5;

export const add = (a, b, factor = 1) => a.map((x, n) => x + factor * b[n]);
export const dot = (a, b) => a.reduce((sum, x, n) => sum + x * b[n], 0);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const clamped = (x, low, high) => Math.min(Math.max(x, low), high);

/** Unit vectors { right, up, forward }. */
export function basis({ eye, target, up }) {
  const forward = unit(add(target, eye, -1));
  const right = unit(cross(forward, up));
  return { right, up: cross(right, forward), forward };
}

/** A vector turned about a unit axis, by the right hand. */
function turned(a, axis, angle) {
  const across = cross(axis, a);
  const along = dot(axis, a) * (1 - Math.cos(angle));
  return a.map((x, n) => x * Math.cos(angle) + across[n] * Math.sin(angle) + axis[n] * along);
}

/** Turn round the target: about what is up, and about what is to the right, short of the poles. */
export function orbit(camera, dx, dy) {
  const { right, forward } = basis(camera);
  const up = unit(camera.up);
  const height = Math.asin(clamped(-dot(forward, up), -1, 1));
  const rise = clamped(height + dy * TURN, -MOST_HEIGHT, MOST_HEIGHT) - height;
  const way = turned(turned(add(camera.eye, camera.target, -1), right, -rise), up, -dx * TURN);
  return { ...camera, eye: add(camera.target, way) };
}

/** Move sideways by what lies under the pointer at the target's depth. */
export function pan(camera, dx, dy) {
  const { right, up } = basis(camera);
  const height = shownHeight(camera);
  const by = add(right.map((x) => -dx * height * x), up, dy * height);
  return { ...camera, eye: add(camera.eye, by), target: add(camera.target, by) };
}

/** Go nearer (dragged up) or farther by a share of the distance; parallel rays show less or more. */
export function dolly(camera, dx, dy) {
  const factor = Math.exp(2 * clamped(dy, -2, 2));
  if (camera.name === "orthographic") return { ...camera, height: camera.height * factor };
  return { ...camera, eye: add(camera.target, add(camera.eye, camera.target, -1), factor) };
}

export const GESTURES = { orbit, pan, dolly };

/** Half of what is seen from bottom to top: at a distance of one, or in world units where rays are parallel. */
function halfHeight(camera) {
  return camera.name === "orthographic" ? camera.height / 2 : Math.tan((camera.fov_deg * Math.PI) / 360);
}

/** World units from bottom to top at the target's depth. */
export function shownHeight(camera) {
  const distance = camera.name === "orthographic" ? 1 : Math.hypot(...add(camera.eye, camera.target, -1));
  return 2 * halfHeight(camera) * distance;
}

/** How much more a view shows from bottom to top than the still picture, so that nothing of that is lost at its sides. */
export function roomFor(sizePx, stillPx) {
  return Math.max(1, stillPx[0] / stillPx[1] / (sizePx[0] / sizePx[1]));
}

/** A camera held to distances from which 32 bits tell samples apart. */
export function within(camera, first) {
  const [most, least] = [1e3, 1e-3];
  if (camera.name === "orthographic") {
    return { ...camera, height: clamped(camera.height, least * first.height, most * first.height) };
  }
  const way = add(camera.eye, camera.target, -1);
  const [distance, usual] = [Math.hypot(...way), Math.hypot(...add(first.eye, first.target, -1))];
  return { ...camera, eye: add(camera.target, way, clamped(distance, least * usual, most * usual) / distance) };
}

/**
 * Uniforms of a camera, and the distance by which its rays begin later than at the eye: parallel ones a whole number of steps,
 * in front of the volume.
 */
export function cameraUniforms(camera, room, sizePx, { anchor_world, corners_world, step_world }) {
  const { right, up, forward } = basis(camera);
  let offset = 0;
  if (camera.name === "orthographic") {
    const nearest = Math.min(...corners_world.map((corner) => dot(add(corner, camera.eye, -1), forward)));
    const steps = Math.trunc(nearest / step_world) - 1;
    offset = steps > 0 ? steps * step_world : 0;
  }
  const half = halfHeight(camera) * room;
  const values = {
    eye: add(add(camera.eye, forward, offset), anchor_world, -1),
    forward,
    right: right.map((x) => (x * half * sizePx[0]) / sizePx[1]),
    up: up.map((x) => x * half),
  };
  return { values, offset };
}
