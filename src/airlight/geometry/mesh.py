"""Meshes of triangles, as values."""

from __future__ import annotations

import os
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..transfer import linear_rgb
from ..transfer.colour import MOST_COLOUR, Colour
from ..transfer.given import flag, set_fields, share
from ..volume import FloatArray, checked_affine
from .arrays import IndexArray, colours_of, digest, faces_of, points_of
from .closed import facing


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles that shares its depth with volumes: it hides what lies behind, and fades behind what is in front.

    It is lit from both sides by the scene's lights, as the look of the first visible layer shades (Blinn-Phong where that layer
    is not lit).

    Parameters
    ----------
    vertices
        Points (n, 3), in world units unless ``world_from_mesh`` places them; or a ``trimesh.Trimesh``, with its faces and the
        colours of its vertices.
    faces
        Whole numbers (m, 3): the three vertices of each triangle.
    color
        Colour of all, a factor of ``colors``: linear numbers, or a name or ``#rrggbb`` in sRGB.
    colors
        Colours of the vertices, (n, 3) or (n, 4) with opacities: numbers are linear, bytes (uint8) are sRGB.
    opacity
        Share of the light that is kept from passing, in [0, 1]; a factor of the opacities in ``colors``. A mesh with less than
        one anywhere is drawn as a semi-transparent one.
    world_from_mesh
        Affine (4, 4) that places the vertices; None leaves them where they are.
    smooth
        Whether normals run smoothly from vertex to vertex; otherwise each triangle is flat.
    lit
        Whether lights count; otherwise the colours are shown as they are.
    clipped
        Whether the scene's clips cut it as they cut volumes: what they cut away is not there, and the inner side shows.
    source
        File that it was read from, which scene files name, and the digest of what was in it.

    Raises
    ------
    DataError
        For points that are not finite, faces that name vertices that are not there, no faces, and matrices that place nothing.
    ValueRangeError
        For colours and opacities that are none.
    """

    vertices: FloatArray
    faces: IndexArray
    _: KW_ONLY
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    colors: FloatArray | None = None
    opacity: float = 1.0
    world_from_mesh: FloatArray | None = None
    smooth: bool = True
    lit: bool = True
    clipped: bool = False
    source: tuple[str, str] | None = None

    def __init__(
        self,
        vertices: Any,
        faces: npt.ArrayLike | None = None,
        *,
        color: Colour = (1.0, 1.0, 1.0),
        colors: npt.ArrayLike | None = None,
        opacity: float = 1.0,
        world_from_mesh: npt.ArrayLike | None = None,
        smooth: bool = True,
        lit: bool = True,
        clipped: bool = False,
        source: tuple[str, str] | None = None,
    ) -> None:
        if isinstance(vertices, (str, os.PathLike)):
            raise DataError("mesh", f"got the path {os.fspath(vertices)!r}", "use airlight.Mesh.open(path)")
        if faces is None:
            if not hasattr(vertices, "faces"):
                raise DataError("mesh.faces", "is missing", "give vertices and faces, or a trimesh.Trimesh")
            from .reading import vertex_colours

            colors = vertex_colours(vertices) if colors is None else colors
            vertices, faces = vertices.vertices, vertices.faces
        points = points_of(vertices, "mesh.vertices")
        set_fields(
            self,
            vertices=points,
            faces=faces_of(faces, len(points), "mesh.faces"),
            color=linear_rgb(color, "mesh.color", MOST_COLOUR),
            colors=None if colors is None else colours_of(colors, len(points), "mesh.colors"),
            opacity=share(opacity, "mesh.opacity"),
            world_from_mesh=None if world_from_mesh is None else checked_affine(world_from_mesh, "mesh.world_from_mesh"),
            smooth=flag(smooth, "mesh.smooth"),
            lit=flag(lit, "mesh.lit"),
            clipped=flag(clipped, "mesh.clipped"),
            source=source,
        )

    @staticmethod
    def open(path: str | os.PathLike[str], **options: Any) -> Mesh:
        """Read a mesh of a file: STL, OBJ, PLY or GLB; ``options`` are those of the class.

        Raises
        ------
        FileError
            For files that are missing, damaged, or of other kinds.
        MissingExtraError
            Without the package trimesh.
        """
        from .reading import read_mesh

        return read_mesh(path, **options)

    def moved(self, world_from_world: npt.ArrayLike) -> Mesh:
        """Return the mesh where an affine (4, 4) of the world takes it; nothing of it is uploaded again."""
        made = replace(self, world_from_mesh=checked_affine(world_from_world, "mesh.moved") @ self.matrix)
        made.__dict__["bounds"] = self.bounds
        return made

    @property
    def opaque(self) -> bool:
        """Whether no light passes anywhere."""
        return self.opacity >= 1 and (self.colors is None or bool(self.colors[:, 3].min() >= 1))

    @cached_property
    def matrix(self) -> FloatArray:
        """``world_from_mesh`` (4, 4)."""
        return np.eye(4) if self.world_from_mesh is None else self.world_from_mesh

    @cached_property
    def bounds(self) -> FloatArray:
        """Least and greatest corner (2, 3), in the mesh's own space."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @cached_property
    def corners_world(self) -> FloatArray:
        """Eight corners (8, 3) of its box, in the world."""
        corners = np.stack(np.meshgrid(*self.bounds.T, indexing="ij"), axis=-1).reshape(-1, 3)
        return np.asarray(corners @ self.matrix[:3, :3].T + self.matrix[:3, 3])

    @cached_property
    def normals(self) -> FloatArray:
        """Normals (n, 3) of the vertices in the mesh's space, of length one: means of the faces around, by their areas.

        Zero where a vertex has no face around it.
        """
        a, b, c = self.vertices[self.faces].swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        found = np.empty_like(self.vertices)
        numbers, count = self.faces.ravel(), len(self.vertices)
        for axis in range(3):
            found[:, axis] = np.bincount(numbers, np.repeat(across[:, axis], 3), count)
        lengths = np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(found / np.where(lengths > 0, lengths, 1.0))

    @cached_property
    def outward(self) -> int:
        """Return 1 where the faces of a closed mesh look out as it lies in the world, -1 where they look in.

        Raises
        ------
        DataError
            For meshes that are open or enclose nothing.
        """
        return facing(self) * int(np.sign(np.linalg.det(self.matrix[:3, :3])))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mesh) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} faces)"

    @cached_property
    def _content(self) -> tuple[Any, ...]:
        arrays = digest(self.vertices, self.faces, self.colors, self.world_from_mesh)
        return arrays, self.color, self.opacity, self.smooth, self.lit, self.clipped, self.source
