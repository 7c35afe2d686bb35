"""Meshes, lines and points: where rays meet them, in which colours, and how that is put in order with volumes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..clips import Clip
from ..geometry import Lines, Mesh, Points
from ..scene import Scene
from ..stage import make_stage
from ..volume import FloatArray
from .camera import pixel_width
from .clips import NOWHERE, Piece, kept_along
from .integrate import Accumulated
from .intersections import intersections
from .setup import BoolArray, IntArray, Sample, Setup
from .shade import SHADES

FACES_AT_ONCE = 512


@dataclass(frozen=True, eq=False)
class Covers:
    """What n rays meet, the nearest first: distances (n, m), inf where there is no more; associated colour, and opacity.

    All that lies behind something opaque is left out.
    """

    t_world: FloatArray
    rgb: FloatArray
    alpha: FloatArray

    @property
    def opaque_at(self) -> FloatArray:
        """Distances (n,) at which rays end, inf where nothing is opaque."""
        return np.asarray(np.where(self.alpha >= 1, self.t_world, np.inf).min(axis=1, initial=np.inf))


def covers(scene: Scene, setup: Setup, origin: FloatArray, direction: FloatArray, layers: int | None = None) -> Covers:
    """All that rays (n, 3) meet of the meshes, lines and points of a scene; ``layers`` bounds what is semi-transparent."""
    n = len(origin)
    parts = [_left(_met(shape, setup, origin, direction), shape, scene.clips, origin, direction) for shape in scene.meshes]
    t_world = np.concatenate([np.full((n, 1), np.inf), *(part.t_world for part in parts)], axis=1)
    rgb = np.concatenate([np.zeros((n, 1, 3)), *(part.rgb for part in parts)], axis=1)
    alpha = np.concatenate([np.zeros((n, 1)), *(part.alpha for part in parts)], axis=1)
    order = np.argsort(t_world, axis=1, kind="stable")
    t_world, alpha = np.take_along_axis(t_world, order, axis=1), np.take_along_axis(alpha, order, axis=1)
    rgb = np.take_along_axis(rgb, order[..., None], axis=1)
    # Leave out what is hidden, and layers beyond the last one.
    opaque = alpha >= 1
    hidden: BoolArray = np.asarray(np.cumsum(opaque, axis=1) - opaque > 0)
    if layers is not None:
        hidden = hidden | ((np.cumsum(~opaque & np.isfinite(t_world), axis=1) > layers) & ~opaque)
    t_world = np.where(hidden, np.inf, t_world)
    return Covers(t_world, np.where(hidden[..., None], 0.0, rgb), np.where(hidden, 0.0, alpha))


def _left(
    found: Covers, shape: Mesh | Lines | Points, clips: tuple[Clip, ...], origin: FloatArray, direction: FloatArray
) -> Covers:
    """What clips leave of a mesh that is to be cut."""
    if not (isinstance(shape, Mesh) and shape.clipped and clips):
        return found
    met = np.isfinite(found.t_world)
    met &= kept_along(clips, origin, direction, np.where(met, found.t_world, 0.0))
    return Covers(np.where(met, found.t_world, np.inf), found.rgb * met[..., None], found.alpha * met)


def _met(shape: Mesh | Lines | Points, setup: Setup, origin: FloatArray, direction: FloatArray) -> Covers:
    if isinstance(shape, Mesh):
        return _mesh(shape, setup, origin, direction)
    if isinstance(shape, Lines):
        found = [_line(shape, setup, ends, origin, direction) for ends in shape.points]
    else:
        found = [_point(shape, setup, middle, origin, direction) for middle in shape.points]
    t_world = np.stack(found, axis=1)
    rgba = np.ones((len(shape.points), 4)) if shape.colors is None else np.array(shape.colors)
    rgba = rgba * (*shape.color, shape.opacity)
    alpha = np.where(np.isfinite(t_world), rgba[:, 3], 0.0)
    return Covers(t_world, alpha[..., None] * rgba[:, :3], alpha)


def _mesh(mesh: Mesh, setup: Setup, origin: FloatArray, direction: FloatArray) -> Covers:
    """Triangles, by the shares of their corners in the points where rays meet their planes."""
    matrix = np.eye(4) if mesh.world_from_mesh is None else mesh.world_from_mesh
    vertices = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    found: list[tuple[IntArray, FloatArray, FloatArray]] = []
    for first in range(0, len(mesh.faces), FACES_AT_ONCE):
        faces = mesh.faces[first : first + FACES_AT_ONCE]
        t_world, shares = intersections(vertices[faces], origin, direction)
        rays, which = (numbers.astype(np.int64) for numbers in np.nonzero(np.isfinite(t_world)))
        t_met = t_world[rays, which]
        p_world = origin[rays] + t_met[:, None] * direction[rays]
        rgba = _seen(mesh, matrix, vertices, faces[which], shares[rays, which], setup, p_world, direction[rays])
        found.append((rays, t_met, rgba))
    rays = np.concatenate([part[0] for part in found])
    # Give each ray as many places as the one that meets most.
    order = np.argsort(rays, kind="stable")
    rays = rays[order]
    count = np.bincount(rays, minlength=len(origin))
    place = np.arange(len(rays)) - np.repeat(np.cumsum(count) - count, count)
    most = int(count.max(initial=0))
    t_all, rgba = np.full((len(origin), most), np.inf), np.zeros((len(origin), most, 4))
    t_all[rays, place] = np.concatenate([part[1] for part in found])[order]
    rgba[rays, place] = np.concatenate([part[2] for part in found])[order]
    return Covers(t_all, rgba[..., :3], rgba[..., 3])


def _seen(
    mesh: Mesh,
    matrix: FloatArray,
    vertices: FloatArray,
    faces: Any,
    shares: FloatArray,
    setup: Setup,
    p_world: FloatArray,
    direction: FloatArray,
) -> FloatArray:
    """Associated colour and opacity (n, 4) of points of a mesh."""
    rgba = np.ones((len(faces), 4))
    if mesh.colors is not None:
        rgba = (shares[..., None] * mesh.colors[faces]).sum(axis=1)
    rgba = rgba * (*mesh.color, mesh.opacity)
    if mesh.lit:
        a, b, c = vertices[faces].swapaxes(0, 1)
        normal = flat = np.cross(b - a, c - a)
        if mesh.smooth:
            mixed = (shares[..., None] * mesh.normals[faces]).sum(axis=1) @ np.linalg.inv(matrix[:3, :3])
            normal = np.where(np.linalg.norm(mixed, axis=1, keepdims=True) > 1e-6, mixed, flat)
        nothing = np.zeros(len(faces))
        sample = Sample(nothing, nothing > 0, p_world, p_world, nothing)
        lit = SHADES[setup.stages["shade"].name](setup, sample, -normal, -direction)
        rgba[:, :3] = rgba[:, :3] * lit.diffuse + lit.specular
    rgba[:, :3] *= rgba[:, 3:]
    return rgba


def surface_setup(setup: Setup) -> Setup:
    """What lights meshes: the look's shade stage where it is lit, without a threshold, and no occlusion."""
    shade: Any = setup.layer.look.shade
    if not getattr(shade, "lit", True):
        shade = make_stage("shade", "blinn_phong")
    if hasattr(shade, "gradient_threshold"):
        shade = replace(shade, gradient_threshold=0.0)
    return replace(setup, stages={**setup.stages, "shade": shade, "visibility": make_stage("visibility", "none")})


def _line(shape: Lines, setup: Setup, ends: FloatArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Distances (n,) at which rays meet a line's band: as wide at each end as it tells there, and half of that longer."""
    camera: Any = setup.camera
    if camera.looks_round:
        return _round_line(shape, setup, ends, origin, direction)
    right, up, forward = camera.basis()
    depth = (ends - np.array(camera.eye)) @ forward
    near = 1e-6 * depth.max() if camera.name == "perspective" else 0.0
    if (depth <= near).all():
        return np.full(len(origin), np.inf)
    for end in (0, 1):
        if depth[end] < near:
            ends = ends.copy()
            ends[end] += (near - depth[end]) / (depth[1 - end] - depth[end]) * (ends[1 - end] - ends[end])
    seen = np.stack([(ends - np.array(camera.eye)) @ axis for axis in (right, up, forward)], axis=1)
    on_image = seen[:, :2] / (seen[:, 2:] if camera.name == "perspective" else 1.0)
    way = on_image[1] - on_image[0]
    length = float(np.hypot(*way))
    along = (way / length if length > 0 else np.array([1.0, 0.0])) @ np.stack([right, up])
    half = _half_width(shape, setup, seen[:, 2])
    ends = ends + np.array([[-half[0]], [half[1]]]) * along
    across = np.cross(along, forward)
    # The plane holds the line and the direction across: the ray meets it once, between the edges or not.
    normal = np.cross(ends[1] - ends[0], across)
    t_world = _plane(normal, ends[0], origin, direction)
    met = origin + np.where(np.isfinite(t_world), t_world, 0.0)[:, None] * direction - ends[0]
    axis = np.cross(across, normal)
    share = (met @ axis) / ((ends[1] - ends[0]) @ axis)
    aside = np.abs((met - share[:, None] * (ends[1] - ends[0])) @ across)
    inside = (share >= 0) & (share <= 1) & (aside <= half[0] + share * (half[1] - half[0]))
    return np.where(inside, t_world, np.inf)


def _round_line(shape: Lines, setup: Setup, ends: FloatArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """The same for cameras that look all round, where widths are those at distances from the eye."""
    camera: Any = setup.camera
    eye = np.array(camera.eye)
    across = np.cross(*(ends - eye))
    across /= np.linalg.norm(across)
    away = np.linalg.norm(ends - eye, axis=1)
    along = np.cross(across, (ends - eye) / away[:, None])
    ends = ends + np.array([[-1.0], [1.0]]) * _half_width(shape, setup, away)[:, None] * along
    t_world = _plane(np.cross(ends[1] - ends[0], across), ends[0], origin, direction)
    met = origin + np.where(np.isfinite(t_world), t_world, 0.0)[:, None] * direction
    share = ((met - ends[0]) @ (ends[1] - ends[0])) / ((ends[1] - ends[0]) @ (ends[1] - ends[0]))
    half = _half_width(shape, setup, np.linalg.norm(ends[0] + share[:, None] * (ends[1] - ends[0]) - eye, axis=1))
    inside = (share >= 0) & (share <= 1) & (np.abs((met - ends[0]) @ across) <= half)
    return np.where(inside, t_world, np.inf)


def _point(shape: Points, setup: Setup, middle: FloatArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Distances (n,) at which rays meet a regular polygon of twelve corners that faces the image."""
    camera: Any = setup.camera
    right, up, forward = camera.basis()
    if camera.looks_round:
        forward = (middle - camera.eye) / np.linalg.norm(middle - camera.eye)
        right = np.cross(forward, np.eye(3)[np.abs(forward).argmin()])
        right /= np.linalg.norm(right)
        up = np.cross(forward, right)
    depth = np.array([(middle - np.array(camera.eye)) @ forward])
    if depth[0] <= 0:
        return np.full(len(origin), np.inf)
    t_world = _plane(forward, middle, origin, direction)
    met = origin + np.where(np.isfinite(t_world), t_world, 0.0)[:, None] * direction - middle
    x, y = met @ right, met @ up
    sector = math.pi / 6
    angle = np.mod(np.arctan2(y, x), sector) - sector / 2
    inside = np.hypot(x, y) * np.cos(angle) <= _half_width(shape, setup, depth)[0] * math.cos(sector / 2)
    return np.where(inside, t_world, np.inf)


def _half_width(shape: Lines | Points, setup: Setup, depth: FloatArray) -> FloatArray:
    """Half of the width [world] at depths along the view."""
    if shape.width_px is None:
        assert shape.width_world is not None
        return np.full_like(depth, shape.width_world / 2)
    camera: Any = setup.camera
    if camera.name == "orthographic":
        return np.full_like(depth, shape.width_px / 2 * camera.height / setup.size_px[1])
    if camera.looks_round:
        return shape.width_px / 2 * pixel_width(camera, setup.size_px, depth)
    return np.asarray(shape.width_px * depth * math.tan(math.radians(camera.fov_deg) / 2) / setup.size_px[1])


def _plane(normal: FloatArray, point: FloatArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Distances (n,) at which rays meet a plane in front of them."""
    pace = direction @ normal
    t_world = ((point - origin) @ normal) / np.where(pace == 0, 1.0, pace)
    return np.where((pace != 0) & (t_world > 0), t_world, np.inf)


def parts_of(found: Covers | None, pieces: Iterable[Piece]) -> Iterator[tuple[Piece, Piece]]:
    """Yield pieces of rays, each with its parts between covers, nearest first; ``end <= begin`` is none.

    No clip cuts a part where a cover does.
    """
    for piece in pieces:
        if found is None:
            yield piece, piece
            continue
        begin = piece.begin
        for number in range(found.t_world.shape[1]):
            end = np.maximum(begin, np.minimum(piece.end, found.t_world[:, number]))
            near = np.where(begin > piece.begin, NOWHERE, piece.near)
            yield piece, Piece(begin, end, near, np.where(end < piece.end, NOWHERE, piece.far))
            begin = end


def put_before(found: Covers, taken: BoolArray, acc: Accumulated, t_world: FloatArray, some: BoolArray) -> None:
    """Put covers up to distances (n,) behind what some of the rays have met; ``taken`` (n, m) are those already put."""
    for number in range(found.t_world.shape[1]):
        here = some & ~taken[:, number] & (found.t_world[:, number] <= t_world)
        put(acc, found.rgb[:, number], found.alpha[:, number], found.t_world[:, number], here)
        taken[:, number] |= here


def put(acc: Accumulated, rgb: FloatArray, alpha: FloatArray, t_world: FloatArray, some: BoolArray) -> None:
    """Put covers behind what some of the rays have met so far."""
    through = np.where(some, 1 - acc.alpha, 0.0)
    after = acc.alpha + through * alpha
    passes = some & (acc.alpha < 0.5) & (after >= 0.5)
    acc.rgb += through[:, None] * rgb
    acc.alpha = after
    acc.t_world = np.where(passes, t_world, acc.t_world)


def over(found: Covers, acc: Accumulated, is_surface: bool) -> Accumulated:
    """Order the result of whole rays among covers: behind them all, but for what lies nearer than a surface that was hit."""
    n, m = found.t_world.shape
    blank = np.zeros(n)
    seen = Accumulated(np.zeros((n, 3)), blank.copy(), np.full(n, np.inf), acc.value, acc.length)
    nearer = is_surface & (found.t_world < acc.t_world[:, None])
    for number in range(m):
        put(seen, found.rgb[:, number], found.alpha[:, number], found.t_world[:, number], nearer[:, number])
    put(seen, acc.rgb, acc.alpha, acc.t_world, np.ones(n, dtype=bool))
    for number in range(m):
        put(seen, found.rgb[:, number], found.alpha[:, number], found.t_world[:, number], ~nearer[:, number])
    return seen
