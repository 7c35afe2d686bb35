"""Where the object is under a transfer function, and a camera that shows it."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..scene import VIEWS, Light
from ..stages.camera import Camera
from ..transfer import TransferFunction
from ..volume import FloatArray, Volume, domain_index
from .survey import Survey

FOV_DEG = 30.0
MARGIN = 1.05
LEAST_OPACITY = 0.02
FLAT = 0.4
HALVES = (-0.5, 0.5)


def visible_points(volume: Volume, function: TransferFunction, found: Survey) -> FloatArray:
    """World positions (n, 3) of samples that are seen, specks left out; the corners of the domain where nothing is."""
    seen = _seen(volume, function, found)
    for axis in range(3):
        count = seen.sum(axis=tuple(a for a in range(3) if a != axis))
        kept = np.flatnonzero(count > 0.004 * count.max()) if count.max() else np.empty(0, dtype=np.intp)
        if kept.size == 0:
            return volume.corners_world()
        outside = np.ones(len(count), dtype=bool)
        outside[kept[0] : kept[-1] + 1] = False
        np.moveaxis(seen, axis, 0)[outside] = False
    # The first and the last of each row hold all that can touch the border of the picture; with them, half a step around.
    rows = seen.any(axis=2)
    z, y = np.nonzero(rows)
    first, last = seen.argmax(axis=2)[rows], seen.shape[2] - 1 - seen[:, :, ::-1].argmax(axis=2)[rows]
    corners = [np.stack([x, y + dy, z + dz], axis=1) for x in (first - 0.5, last + 0.5) for dy in HALVES for dz in HALVES]
    p_index = np.concatenate(corners) * np.array(found.stride[::-1], dtype=np.float64)
    low, high = domain_index(volume.size, cells=False)
    p_index = np.clip(p_index, low, high)
    return np.asarray(p_index @ volume.world_from_index[:3, :3].T + volume.world_from_index[:3, 3])


def _seen(volume: Volume, function: TransferFunction, found: Survey) -> npt.NDArray[np.bool_]:
    """Samples that are seen themselves, or that border a step between samples which passes through what is seen."""
    first, last = function.domain
    if last <= first:
        return found.filled & bool(function.extinctions[0] > 0)
    # The mean extinction between two values is the difference of the antiderivative over that of the values.
    values = (found.samples - first) / (last - first)
    axis = np.linspace(0, 1, 512)
    extinction = np.interp(axis, (function.values - first) / (last - first), function.extinctions)
    primitive = np.concatenate([[0.0], np.cumsum((extinction[1:] + extinction[:-1]) / 2 * np.diff(axis))])
    amount = np.interp(values, axis, primitive)
    amount += np.minimum(values, 0) * extinction[0] + np.maximum(values - 1, 0) * extinction[-1]
    seen = np.interp(values, axis, extinction) * max(volume.spacing) > LEAST_OPACITY
    for d, (stride, spacing) in enumerate(zip(found.stride, volume.spacing[::-1], strict=True)):
        step = np.abs(np.diff(values, axis=d))
        opacity = np.abs(np.diff(amount, axis=d)) * (stride * spacing)
        passes = opacity > LEAST_OPACITY * np.maximum(step, 1e-300)
        np.moveaxis(seen, d, 0)[:-1] |= np.moveaxis(passes, d, 0)
        np.moveaxis(seen, d, 0)[1:] |= np.moveaxis(passes, d, 0)
    return np.asarray(seen & found.filled)


def chosen_direction(points: FloatArray, volume: Volume, found: Survey) -> tuple[FloatArray, FloatArray]:
    """Direction towards the eye, and up: the front of anatomy, else a corner, turned towards the object's large faces."""
    extents = np.ptp(points, axis=0)
    extents = np.maximum(extents, 0.02 * extents.max() or 1.0)
    up = np.array([0.0, 0.0, 1.0])
    base = np.asarray(VIEWS["iso"][0], dtype=np.float64)
    if volume.anatomical:
        thin = int(np.argmin(extents))
        if thin == 1 or extents[thin] > FLAT * np.median(extents):
            behind_table = found.kind == "ct" and _table_in_front(volume, found)
            return np.asarray(VIEWS["back" if behind_table else "front"][0], dtype=np.float64), up
        # A few slices of a body are looked at from the feet, as radiologists do, or from the left.
        base = np.array([0.0, -0.75, -0.6]) if thin == 2 else np.array([0.8, -0.5, 0.2])
    faces = extents.min() / extents
    direction = base * faces**0.6
    return direction / np.linalg.norm(direction), up


def _table_in_front(volume: Volume, found: Survey) -> bool:
    """Whether the front of a CT is hidden by the table: rays meet something thin, then air, then the body.

    Patients lie on their back, as a rule, but files that are turned by mistake are about.
    """
    axis = int(np.argmax(np.abs(volume.world_from_index[1, :3])))
    solid = np.moveaxis(found.samples > found.begin, 2 - axis, 2)
    if volume.world_from_index[1, axis] < 0:
        solid = solid[..., ::-1]
    front, back = _thin_first(solid), _thin_first(solid[..., ::-1])
    return front > 0.2 and front > 2 * back


def _thin_first(solid: npt.NDArray[np.bool_]) -> float:
    """Share of rows that meet something before a gap, which is less than a fifth of all they meet."""
    begin = solid.argmax(axis=-1)[..., None]
    gap = ~solid & (np.arange(solid.shape[-1]) > begin)
    first = np.where(gap.any(axis=-1), gap.argmax(axis=-1), solid.shape[-1]) - begin[..., 0]
    met = solid.sum(axis=-1)
    return float((first < 0.2 * met)[met > 0].mean()) if met.any() else 0.0


def fitted_camera(
    points: FloatArray, to_eye: FloatArray, up: FloatArray, aspect: float, room: float = 1.0, fov_deg: float = FOV_DEG
) -> Camera:
    """Perspective camera that looks along a direction and shows all points, in the middle of the picture, with room round."""
    right = np.cross(up, to_eye)
    right /= np.linalg.norm(right)
    above = np.cross(to_eye, right)
    tangent = math.tan(math.radians(fov_deg) / 2) / (MARGIN * room)
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    distance = 0.0
    for _ in range(3):
        p = points - target
        x, y, towards = p @ right, p @ above, p @ to_eye
        distance = float((towards + np.maximum(np.abs(x) / (tangent * aspect), np.abs(y) / tangent)).max())
        distance = max(distance, 1e-6 * float(np.abs(points).max()), 1e-12)
        # Where the picture's border is touched on one side only, the middle moves over there.
        depth = np.maximum(distance - towards, 1e-3 * distance)
        px, py = x / depth, y / depth
        target = target + distance * ((px.min() + px.max()) / 2 * right + (py.min() + py.max()) / 2 * above)
    p = points - target
    aside = np.maximum(np.abs(p @ right) / (tangent * aspect), np.abs(p @ above) / tangent)
    distance = max(float((p @ to_eye + aside).max()), distance * 1e-3, 1e-12)
    x, y, z = (float(c) for c in target + distance * to_eye)
    tx, ty, tz = (float(c) for c in target)
    ux, uy, uz = (float(c) for c in up)
    return Camera.perspective(eye=(x, y, z), target=(tx, ty, tz), up=(ux, uy, uz), fov_deg=fov_deg)


def chosen_lights(to_eye: FloatArray, up: FloatArray, key: float = 1.0, fill: float = 0.35) -> tuple[Light, ...]:
    """Return a key light from the upper left of the eye, and a weaker one at the eye."""
    right = np.cross(up, to_eye)
    right /= np.linalg.norm(right)
    above = np.cross(to_eye, right)
    x, y, z = (float(c) for c in to_eye - 0.65 * right + 0.75 * above)
    return Light.directional(to_light=(x, y, z), intensity=key), Light.head(intensity=fill)
