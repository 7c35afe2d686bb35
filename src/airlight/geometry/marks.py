"""Lines and points, as values, and the triangles that show them to a camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError, ValueRangeError
from ..keeping import Kept
from ..stages.camera import Camera, Orthographic
from ..transfer import linear_rgb
from ..transfer.colour import MOST_COLOUR, Colour
from ..transfer.given import positive, set_fields, share
from ..volume import FloatArray, Volume
from .arrays import array_of, colours_of, digest, frozen, points_of
from .marks_round import round_bands, round_disks
from .mesh import Mesh

ROUND = 12  # corners of a point
EDGES = ((0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7))
AXES: tuple[Colour, ...] = ("#d8433b", "#4fa64f", "#3f6fd8")


@dataclass(frozen=True, eq=False)
class _Marks:
    """What lines and points share: width, colour and opacity."""

    points: FloatArray
    _: KW_ONLY
    color: tuple[float, float, float]
    colors: FloatArray | None
    opacity: float
    width_px: float | None
    width_world: float | None

    def _set(
        self,
        name: str,
        count: int,
        color: Colour,
        colors: Any,
        opacity: float,
        width_px: Any,
        width_world: Any,
        usual_px: float,
    ) -> None:
        if width_px is not None and width_world is not None:
            raise ValueRangeError(f"{name}.width_px", "and width_world exclude each other", "leave one of them out")
        width_px = usual_px if width_px is None and width_world is None else width_px
        set_fields(
            self,
            color=linear_rgb(color, f"{name}.color", MOST_COLOUR),
            colors=None if colors is None else colours_of(colors, count, f"{name}.colors"),
            opacity=share(opacity, f"{name}.opacity"),
            width_px=None if width_px is None else positive(width_px, f"{name}.width_px"),
            width_world=None if width_world is None else positive(width_world, f"{name}.width_world"),
        )

    @property
    def corners_world(self) -> FloatArray:
        """Points (n, 3) that must be seen, in the world."""
        return self.points.reshape(-1, 3)

    def half_width(self, camera: Camera, size_px: tuple[int, int], depth: FloatArray) -> FloatArray:
        """Half of the width [world] at depths along the view, for cameras that look all round at distances."""
        if self.width_px is None:
            assert self.width_world is not None
            return np.full_like(depth, self.width_world / 2)
        at_eye, more = camera.pixel_width(size_px)
        return self.width_px / 2 * (at_eye + more * depth)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @cached_property
    def _content(self) -> tuple[Any, ...]:
        return digest(self.points, self.colors), self.color, self.opacity, self.width_px, self.width_world


@dataclass(frozen=True, eq=False, init=False)
class Lines(_Marks):
    """Straight lines with their depth among volumes and meshes, in colours that no light changes.

    They are bands that face the image: of the same width in pixels everywhere, or of a width in the world.

    Parameters
    ----------
    points
        Ends (n, 2, 3) of n lines in the world, or points (n, 3) that one line after the other joins.
    color, colors
        Colour of all, a factor of ``colors``: (n, 3) or (n, 4) with opacities, one a line. Numbers are linear, bytes sRGB.
    opacity
        In [0, 1].
    width_px, width_world
        Width in pixels (2 unless told), or in world units.

    Raises
    ------
    DataError
        For points that are not finite, and arrays of other shapes.
    ValueRangeError
        For colours, opacities and widths that are none.
    """

    def __init__(
        self,
        points: npt.ArrayLike,
        *,
        color: Colour = (1.0, 1.0, 1.0),
        colors: npt.ArrayLike | None = None,
        opacity: float = 1.0,
        width_px: float | None = None,
        width_world: float | None = None,
    ) -> None:
        given = array_of(points, "lines.points", "give ends (n, 2, 3), or points (n, 3) in a row")
        if given.ndim == 2 and len(given) > 1:
            given = np.stack([given[:-1], given[1:]], axis=1)
        if given.ndim != 3 or given.shape[1:] != (2, 3):
            raise DataError(
                "lines.points", f"has the shape {np.shape(points)}", "give ends (n, 2, 3), or points (n, 3) in a row"
            )
        flat = points_of(given.reshape(-1, 3), "lines.points")
        set_fields(self, points=frozen(flat.reshape(-1, 2, 3), np.float64))
        self._set("lines", len(given), color, colors, opacity, width_px, width_world, 2.0)

    @staticmethod
    def box(volume: Volume, *, cells: bool = False, color: Colour = (1.0, 1.0, 1.0), **options: Any) -> Lines:
        """Edges of a volume's box: through the centres of its outermost voxels, or round their cells.

        Raises
        ------
        DataError
            For what is no volume.
        """
        if not isinstance(volume, Volume):
            raise DataError("lines.box", f"got a {type(volume).__name__}", "give an airlight.Volume")
        return Lines(volume.corners_world(cells)[np.array(EDGES)], color=color, **options)

    @staticmethod
    def axes(
        *, origin: Sequence[float] = (0.0, 0.0, 0.0), length: float = 1.0, colors: Sequence[Colour] = AXES, **options: Any
    ) -> Lines:
        """Three lines along the world's x, y and z: red, green and blue unless told."""
        start = points_of([origin], "lines.axes.origin")
        ends = start + positive(length, "lines.axes.length") * np.eye(3)
        chosen = np.array([linear_rgb(c, "lines.axes.colors") for c in colors])
        return Lines(np.stack([np.broadcast_to(start, (3, 3)), ends], axis=1), colors=chosen, **options)

    def __repr__(self) -> str:
        return f"Lines({len(self.points)})"

    def mesh(self, camera: Camera, size_px: tuple[int, int]) -> Mesh | None:
        """Two triangles a line that face the image, half a width longer at each end; None where all lies behind the eye."""
        if camera.looks_round:
            numbers, bands = round_bands(self.points - camera.eye, lambda away: self.half_width(camera, size_px, away))
            return _unlit(self, bands + camera.eye, _quads(len(numbers)), numbers)
        seen = _View(camera)
        ends = seen.of(self.points)
        rows, ends = seen.in_front(ends)
        if not len(rows):
            return None
        along = np.diff(seen.on_image(ends), axis=1)[:, 0]
        length = np.linalg.norm(along, axis=1, keepdims=True)
        along = np.where(length > 0, along / np.where(length > 0, length, 1.0), (1.0, 0.0))
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        half = self.half_width(camera, size_px, ends[..., 2])
        corners = np.repeat(ends, 2, axis=1)
        for number, (end, forth, side) in enumerate(((0, -1, -1), (0, -1, 1), (1, 1, -1), (1, 1, 1))):
            corners[:, number, :2] += half[:, end, None] * (forth * along + side * across)
        return _unlit(self, seen.back(corners), _quads(len(rows)), rows)


@dataclass(frozen=True, eq=False, init=False)
class Points(_Marks):
    """Points with their depth among volumes and meshes: disks that face the image, in colours that no light changes.

    Parameters
    ----------
    points
        Points (n, 3) in the world.
    color, colors, opacity
        As for ``Lines``; ``colors`` has one a point.
    width_px, width_world
        Diameter in pixels (6 unless told), or in world units.

    Raises
    ------
    DataError
        For points that are not finite, and arrays of other shapes.
    ValueRangeError
        For colours, opacities and widths that are none.
    """

    def __init__(
        self,
        points: npt.ArrayLike,
        *,
        color: Colour = (1.0, 1.0, 1.0),
        colors: npt.ArrayLike | None = None,
        opacity: float = 1.0,
        width_px: float | None = None,
        width_world: float | None = None,
    ) -> None:
        set_fields(self, points=points_of(points, "points.points"))
        self._set("points", len(self.points), color, colors, opacity, width_px, width_world, 6.0)

    def __repr__(self) -> str:
        return f"Points({len(self.points)})"

    def mesh(self, camera: Camera, size_px: tuple[int, int]) -> Mesh | None:
        """Triangles of a regular polygon a point; None where all lie behind the eye."""
        if camera.looks_round:
            disks = round_disks(self.points - camera.eye, lambda away: self.half_width(camera, size_px, away), ROUND)
            return _unlit(self, disks + camera.eye, _fans(len(disks)), np.arange(len(disks)))
        seen = _View(camera)
        middles = seen.of(self.points)
        rows = np.nonzero(middles[:, 2] > seen.nearest(middles))[0]
        if not len(rows):
            return None
        middles = middles[rows]
        half = self.half_width(camera, size_px, middles[:, 2])
        angle = 2 * np.pi * np.arange(ROUND) / ROUND
        corners = np.repeat(middles[:, None], ROUND, axis=1)
        corners[..., :2] += half[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return _unlit(self, seen.back(corners), _fans(len(rows)), rows)


class _View:
    """Points as a camera sees them: to the right, up and forward from its eye, in world units."""

    def __init__(self, camera: Camera) -> None:
        self.eye, self.axes = np.array(camera.eye), np.stack(camera.basis())
        self.parallel = isinstance(camera, Orthographic)

    def of(self, points: FloatArray) -> FloatArray:
        return np.asarray((points - self.eye) @ self.axes.T)

    def back(self, seen: FloatArray) -> FloatArray:
        return np.asarray(seen @ self.axes + self.eye)

    def on_image(self, seen: FloatArray) -> FloatArray:
        return seen[..., :2] if self.parallel else seen[..., :2] / seen[..., 2:]

    def nearest(self, seen: FloatArray) -> float:
        """Depth from which on something is seen."""
        return 0.0 if self.parallel else 1e-6 * float(np.abs(seen[..., 2]).max())

    def in_front(self, ends: FloatArray) -> tuple[npt.NDArray[np.int64], FloatArray]:
        """Numbers of the lines that lie in front of the eye, and their ends (n, 2, 3), cut there."""
        near = self.nearest(ends)
        rows = np.nonzero((ends[..., 2] > near).any(axis=1))[0]
        ends = ends[rows].copy()
        for end in (0, 1):
            behind = ends[:, end, 2] < near
            one, other = ends[behind, end], ends[behind, 1 - end]
            share = (near - one[:, 2:]) / (other[:, 2:] - one[:, 2:])
            ends[behind, end] = one + share * (other - one)
        return rows, ends


def _quads(count: int) -> npt.NDArray[np.int64]:
    return np.asarray(4 * np.arange(count)[:, None, None] + np.array([[0, 1, 2], [2, 1, 3]]))


def _fans(count: int) -> npt.NDArray[np.int64]:
    fan = np.array([[0, k, k + 1] for k in range(1, ROUND - 1)])
    return np.asarray(ROUND * np.arange(count)[:, None, None] + fan)


def _unlit(marks: _Marks, corners: FloatArray, faces: npt.NDArray[np.int64], rows: npt.NDArray[np.int64]) -> Mesh:
    colours = None if marks.colors is None else np.repeat(marks.colors[rows], corners.shape[1], axis=0)
    return Mesh(
        corners.reshape(-1, 3),
        faces.reshape(-1, 3),
        color=marks.color,
        colors=colours,
        opacity=marks.opacity,
        smooth=False,
        lit=False,
    )


def mesh_of(marks: Lines | Points, camera: Camera, size_px: tuple[int, int]) -> Mesh | None:
    """Triangles of lines and points, the same object as long as camera and image stay: nothing is uploaded again.

    They are kept with the marks, for the last camera alone: a million points make 400 MB of triangles.
    """
    kept: Kept[tuple[Camera, tuple[int, int]], Mesh | None] = marks.__dict__.setdefault("_triangles", Kept(1))
    return kept.get((camera, size_px), lambda: marks.mesh(camera, size_px))
