"""Clips: the pieces of rays that are drawn, and the faces at which they begin and end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..clips import Box, Clip, Plane, Solid, Sphere
from ..volume import FloatArray
from .integrate import INTEGRATES
from .intersections import intersections
from .region import part_at
from .setup import BoolArray, IntArray, Lit, Sample, Sent, Setup, Slab, dark, made_slab
from .shade import SHADES
from .transfer import TRANSFERS

SKIN_VOXELS = 4.0
LEAST_SOLID = 1e-3
STEEP = 1e30
NOWHERE = -1
WINDINGS_AT_ONCE = 1 << 19


@dataclass(frozen=True, eq=False)
class Piece:
    """One piece of each of n rays: from ``begin`` to ``end`` [world], and the numbers of the clips that cut it there."""

    begin: FloatArray
    end: FloatArray
    near: IntArray
    far: IntArray


@dataclass(frozen=True, eq=False)
class Faces:
    """How cuts (n,) are lit, and the share of it that a point right behind them takes."""

    lit: Lit
    share: FloatArray
    t_world: FloatArray

    def __getitem__(self, rows: IntArray) -> Faces:
        return Faces(Lit(self.lit.diffuse[rows], self.lit.specular[rows]), self.share[rows], self.t_world[rows])


def pieces(
    clips: tuple[Clip, ...], origin: FloatArray, direction: FloatArray, t_enter: FloatArray, t_leave: FloatArray
) -> Iterator[Piece]:
    """Yield the first pieces of rays (n, 3) that all clips keep, then the second ones, and so on; ``end <= begin`` is none.

    Rays are cut at all surfaces; of the parts between those are kept whose middle is.
    """
    n = len(origin)
    found = [surface_distances(clip, origin, direction) for clip in clips]
    owner = np.repeat(np.arange(len(clips)), [roots.shape[1] for roots in found])
    roots = np.concatenate([np.zeros((n, 0)), *found], axis=1)
    low, high = t_enter[:, None], np.maximum(t_enter, t_leave)[:, None]
    stops = np.sort(np.concatenate([low, np.clip(roots, low, high), high], axis=1), axis=1)
    middle = (stops[:, 1:] + stops[:, :-1]) / 2
    kept = kept_along(clips, origin, direction, middle)
    outside = np.zeros((n, 1), dtype=bool)
    begins = kept & ~np.concatenate([outside, kept[:, :-1]], axis=1)
    ends = kept & ~np.concatenate([kept[:, 1:], outside], axis=1)
    for turn in range(1, int(begins.sum(axis=1).max(initial=0)) + 1):
        some = begins.sum(axis=1) >= turn
        first, last = (np.argmax(flags & (np.cumsum(flags, axis=1) == turn), axis=1) for flags in (begins, ends))
        begin = np.take_along_axis(stops, first[:, None], axis=1)[:, 0]
        end = np.take_along_axis(stops, last[:, None] + 1, axis=1)[:, 0]
        end = np.where(some, end, begin)
        yield Piece(begin, end, _cutting(roots, owner, begin, t_enter), _cutting(roots, owner, end, t_leave))


def _cutting(roots: FloatArray, owner: IntArray, t_world: FloatArray, t_domain: FloatArray) -> IntArray:
    """Numbers of the clips whose surfaces lie at distances (n,), ``NOWHERE`` where it is the domain that ends there."""
    if roots.shape[1] == 0:
        return np.full(len(t_world), NOWHERE)
    return np.where(t_world == t_domain, NOWHERE, owner[np.abs(roots - t_world[:, None]).argmin(axis=1)])


def kept_along(clips: tuple[Clip, ...], origin: FloatArray, direction: FloatArray, t_world: FloatArray) -> BoolArray:
    """Which points at distances (n, m) along n rays are drawn."""
    p_world = (origin[:, None, :] + t_world[:, :, None] * direction[:, None, :]).reshape(-1, 3)
    kept = np.ones(t_world.shape, dtype=bool)
    for clip in clips:
        if clip.cuts == "volume":
            kept &= keeps(clip, p_world).reshape(t_world.shape)
            continue
        first, last = (end[:, None] for end in _reach(clip, origin, direction))
        cuts_front, inside = clip.cuts == "front", clip.keep == "inside"
        begins = t_world >= (first if inside else last)
        ends = t_world <= (last if inside else first)
        kept &= (first >= last) | (begins if cuts_front else ends)
    return kept


def _reach(clip: Clip, origin: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (n,) at which rays are in a clip's shape for the first and the last time, from the eye on; equal if never."""
    roots = surface_distances(clip, origin, direction)
    far = np.maximum(np.where(np.isfinite(roots), roots, 0.0).max(axis=1, initial=0.0), 0.0)[:, None] + 1.0
    stops = np.sort(np.concatenate([np.zeros_like(far), np.clip(roots, 0.0, far), far], axis=1), axis=1)
    middle = (stops[:, 1:] + stops[:, :-1]) / 2
    p_world = origin[:, None, :] + middle[:, :, None] * direction[:, None, :]
    inside = _inside(clip, p_world.reshape(-1, 3)).reshape(middle.shape) & (stops[:, 1:] > stops[:, :-1])
    count = inside.shape[1]
    number = np.arange(len(stops))
    first, last = stops[number, inside.argmax(axis=1)], stops[number, count - inside[:, ::-1].argmax(axis=1)]
    meets = inside.any(axis=1)
    return np.where(meets, first, 0.0), np.where(meets, np.where(last == far[:, 0], np.inf, last), 0.0)


def kept_by_all(clips: tuple[Clip, ...], p_world: FloatArray) -> BoolArray:
    """Which of the points (n, 3) are drawn."""
    return np.asarray(np.logical_and.reduce([np.ones(len(p_world), dtype=bool), *(keeps(clip, p_world) for clip in clips)]))


def keeps(clip: Clip, p_world: FloatArray) -> BoolArray:
    """Which of the points (n, 3) a clip keeps, whichever way they are looked at."""
    return np.asarray(_inside(clip, p_world) == (clip.keep == "inside"))


def _inside(clip: Clip, p_world: FloatArray) -> BoolArray:
    """Which of the points (n, 3) lie in a clip's shape."""
    match clip:
        case Plane():
            inside = (p_world - clip.point) @ np.array(clip.normal) >= 0
        case Box():
            p_box = box_coordinates(clip, p_world, 1.0)
            inside = ((p_box >= clip.low) & (p_box <= clip.high)).all(axis=1)
        case Sphere():
            inside = np.linalg.norm(p_world - clip.center, axis=1) <= clip.radius
        case Solid():
            inside = clip.closed.outward * winding(_triangles(clip), p_world) > 0.5
    return np.asarray(inside)


def winding(triangles: FloatArray, p_world: FloatArray) -> FloatArray:
    """How often triangles (m, 3, 3) run round points (n, 3): their solid angles over that of the sphere.

    Of one triangle: twice the angle of ``|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|`` and ``a.(b x c)`` (van Oosterom and
    Strackee 1983).
    """
    found = np.empty(len(p_world))
    at_once = max(1, WINDINGS_AT_ONCE // len(triangles))
    for first in range(0, len(p_world), at_once):
        a, b, c = (triangles[None] - p_world[first : first + at_once, None, None]).transpose(2, 0, 1, 3)
        la, lb, lc = (np.linalg.norm(corner, axis=-1) for corner in (a, b, c))
        ab, bc, ca = ((one * other).sum(axis=-1) for one, other in ((a, b), (b, c), (c, a)))
        angle = np.arctan2((a * np.cross(b, c)).sum(axis=-1), la * lb * lc + ab * lc + bc * la + ca * lb)
        found[first : first + at_once] = angle.sum(axis=1) / (2 * np.pi)
    return found


def _triangles(clip: Solid) -> FloatArray:
    """Corners (m, 3, 3) of a mesh's triangles in the world."""
    matrix = clip.closed.matrix
    return np.asarray((clip.closed.vertices @ matrix[:3, :3].T + matrix[:3, 3])[clip.closed.faces])


def surface_distances(clip: Clip, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Distances (n, m) at which rays pass a clip's surface, or planes of which that is made; infinite where they do not."""
    match clip:
        case Plane():
            normal = np.array(clip.normal)
            return _ratio((clip.point - origin) @ normal, direction @ normal)[:, None]
        case Box():
            o, d = box_coordinates(clip, origin, 1.0), box_coordinates(clip, direction, 0.0)
            return np.concatenate([_ratio(clip.low - o, d), _ratio(clip.high - o, d)], axis=1)
        case Sphere():
            way = origin - np.array(clip.center)
            nearest = -(way * direction).sum(axis=1)
            across = ((way + nearest[:, None] * direction) ** 2).sum(axis=1)
            half = np.sqrt(np.maximum(clip.radius**2 - across, 0.0))
            return np.stack([nearest - half, nearest + half], axis=1)
        case Solid():
            met = np.sort(intersections(_triangles(clip), origin, direction)[0], axis=1)
            return met[:, : int(np.isfinite(met).sum(axis=1).max(initial=0))]
    raise NotImplementedError(clip.kind)


def outward(clip: Clip, p_world: FloatArray) -> FloatArray:
    """Unit normals (n, 3) at points of a clip's surface, towards what is cut away."""
    match clip:
        case Plane():
            normal = -np.broadcast_to(np.array(clip.normal), p_world.shape)
        case Box():
            low, high = np.array(clip.low), np.array(clip.high)
            unit = (2 * box_coordinates(clip, p_world, 1.0) - low - high) / (high - low)
            axis = np.abs(unit).argmax(axis=1)
            sign = np.sign(unit[np.arange(len(unit)), axis])
            normal = sign[:, None] * np.linalg.inv(clip.matrix)[:3, :3][axis]
        case Sphere():
            normal = p_world - clip.center
        case Solid():
            normal = clip.closed.outward * _mesh_normal(clip, p_world)
    facing = normal if clip.keep == "inside" else -normal
    return np.asarray(facing / np.linalg.norm(facing, axis=1, keepdims=True))


def _mesh_normal(clip: Solid, p_world: FloatArray) -> FloatArray:
    """Normals (n, 3) of the triangles on which points lie, as its faces look, mixed of those of the corners if it is smooth."""
    triangles = _triangles(clip)
    b, c = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    flat = np.cross(b, c)
    area = (flat * flat).sum(axis=-1)
    has_area = area > 1e-24 * area.max()
    a, b, c, flat, area = triangles[has_area, 0], b[has_area], c[has_area], flat[has_area], area[has_area]
    faces = clip.closed.faces[has_area]
    way = p_world[:, None] - a
    # Shares of the corners b and c, and the distance from the plane: the triangle whose worst is best holds the point.
    v, w = (np.cross(way, c) * flat).sum(axis=-1) / area, (np.cross(b, way) * flat).sum(axis=-1) / area
    off = np.abs((way * flat).sum(axis=-1)) / area**0.75
    best = np.maximum(np.maximum(-v, -w), np.maximum(v + w - 1, off)).argmin(axis=1)
    if not clip.closed.smooth:
        return np.asarray(flat[best])
    rows = np.arange(len(p_world))
    shares = np.stack([1 - v - w, v, w], axis=-1)[rows, best]
    inverse = np.linalg.inv(clip.closed.matrix[:3, :3])
    return np.asarray((shares[..., None] * clip.closed.normals[faces[best]]).sum(axis=1) @ inverse)


def box_coordinates(clip: Box, vectors: FloatArray, w: float) -> FloatArray:
    """Points (w = 1) or directions (w = 0) (n, 3) of the world in the box's coordinates."""
    matrix = np.linalg.inv(clip.matrix)
    return np.asarray(vectors @ matrix[:3, :3].T + w * matrix[:3, 3])


def _ratio(way: FloatArray, pace: FloatArray) -> FloatArray:
    return np.asarray(np.where(pace == 0, np.inf, way / np.where(pace == 0, 1.0, pace)))


# -- faces


@np.errstate(under="ignore")
def lit_faces(setup: Setup, cut: Sample, numbers: IntArray, to_eye: FloatArray) -> Faces:
    """Light cuts by the normals of the clips that make them; what the domain ends has no face.

    The share is the opacity of a layer of ``SKIN_VOXELS`` filled with what lies at the cut; surfaces are lit by it alone.
    """
    n = len(numbers)
    faces = Faces(Lit(np.zeros((n, 3)), np.zeros((n, 3))), np.zeros(n), cut.t_world)
    if setup.stages["lighting"].name == "unlit":
        return faces
    for number, clip in enumerate(setup.clips):
        rows = np.nonzero((numbers == number) & ~cut.empty)[0]
        if not rows.size:
            continue
        here = cut[rows]
        lit = SHADES[setup.stages["shade"].name](setup, here, -STEEP * outward(clip, here.p_world), to_eye[rows])
        faces.lit.diffuse[rows], faces.lit.specular[rows] = lit.diffuse, lit.specular
        faces.share[rows] = 1.0 if _has_surface(setup) else filled(setup, here).alpha
    return faces


def lit_behind(setup: Setup, faces: Faces, slab: Slab, rgb: FloatArray) -> FloatArray:
    """Colour (n, 3) of slabs that are lit as ``rgb`` by themselves, and less and less as the faces before them are.

    Surfaces, which have no length, keep their own light, unless they are the face.
    """
    behind = (slab.front.t_world + slab.back.t_world) / 2 - faces.t_world
    fades = (
        (behind <= 0).astype(np.float64)
        if _has_surface(setup)
        else np.clip(1 - behind / skin_world(setup), 0, 1) * (slab.length > 0)
    )
    share = (faces.share * fades)[:, None]
    return np.asarray((1 - share) * rgb + share * _lit(faces.lit, slab.rgb, slab.alpha))


def caps(setup: Setup, cut: Sample, numbers: IntArray, to_eye: FloatArray) -> tuple[IntArray, Slab]:
    """Rows of the cuts that are drawn as solid faces, and these: of the colour that endless depth of what is there has."""
    capped = np.array([clip.capped for clip in setup.clips] + [False])[numbers] & ~cut.empty
    attenuates = setup.stages["integrate"].name == "emission_absorption"
    rows = np.nonzero(capped & attenuates)[0]
    if not rows.size:
        return rows, made_slab(dark(0), cut[rows], cut[rows], np.zeros(0))
    sent = filled(setup, cut[rows])
    solid = sent.alpha >= LEAST_SOLID
    rows, rgb = rows[solid], sent.rgb[solid] / sent.alpha[solid, None]
    here, alpha = cut[rows], np.ones(len(rows))
    if setup.stages["lighting"].name != "unlit":
        rgb = _lit(lit_faces(setup, here, numbers[rows], to_eye[rows]).lit, rgb, alpha)
    return rows, Slab(rgb, alpha, rgb / 2, alpha / 2, here, here, np.zeros(len(rows)))


def filled(setup: Setup, here: Sample) -> Sent:
    """What a layer of ``SKIN_VOXELS`` sends that is filled with what lies at samples."""
    tint, opacity = part_at(setup, here.p_index)
    sent = TRANSFERS[setup.stages["transfer"].name](setup, here, here, skin_world(setup) * opacity)
    return replace(sent, rgb=sent.rgb * tint)


def skin_world(setup: Setup) -> float:
    """Thickness of what is lit as the face before it is."""
    return SKIN_VOXELS * setup.finest_world


def _has_surface(setup: Setup) -> bool:
    return INTEGRATES[setup.stages["integrate"].name].has_surface


def _lit(lit: Lit, rgb: FloatArray, alpha: FloatArray) -> FloatArray:
    return np.asarray(rgb * lit.diffuse + alpha[:, None] * lit.specular)
