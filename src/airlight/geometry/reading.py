"""Meshes of files, read by trimesh."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import AirlightError, FileError, MissingExtraError
from ..volume import FloatArray
from .arrays import check_finite, digest
from .mesh import Mesh

KINDS = (".stl", ".obj", ".ply", ".glb")


def read_mesh(path: str | os.PathLike[str], **options: Any) -> Mesh:
    """Read a mesh; scenes of several parts become one. No other file is looked at: pictures on surfaces are left out.

    Raises
    ------
    FileError
        For files that are missing, damaged, without a face, or of other kinds.
    MissingExtraError
        Without the package trimesh.
    DataError
        For points that are not finite.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise FileError(str(path), f"is no mesh by its ending {kind!r}", "use one of " + ", ".join(KINDS))
    try:
        import trimesh
    except ImportError as error:
        raise MissingExtraError("reading a mesh", "needs trimesh", 'pip install "airlight[mesh]"') from error
    try:
        with path.open("rb") as file, np.errstate(all="ignore"):
            # What is not finite would be left out unsaid by its processing.
            found = trimesh.load(file, file_type=kind[1:], process=False, force="mesh")
    except OSError as error:
        raise FileError(str(path), f"cannot be read ({error.strerror or error})", "check the path") from error
    except Exception as error:  # whatever a damaged file leads its reader to
        raise FileError(str(path), f"is damaged or no {kind[1:].upper()} ({error})", "export it again") from error
    if not len(getattr(found, "faces", ())):
        raise FileError(str(path), "holds no faces", "a mesh has at least one; draw loose points with airlight.Points")
    colours = vertex_colours(found)
    vertices, faces = np.asarray(found.vertices, dtype=np.float64), np.asarray(found.faces)
    check_finite(vertices, f"{path}: mesh.vertices")
    if kind == ".stl":
        vertices, faces = _joined(vertices, faces)  # its triangles know of no neighbours
    try:
        mesh = Mesh(vertices, faces, colors=colours)
    except AirlightError as error:
        if error.where.startswith(("mesh.vertices", "mesh.faces")):
            raise type(error)(f"{path}: {error.where}", error.what, error.remedy) from error
        raise
    source = os.path.abspath(path), digest(mesh.vertices, mesh.faces, mesh.colors)
    return replace(mesh, source=source, **options)


def vertex_colours(mesh: Any) -> npt.NDArray[np.uint8] | None:
    """Colours (n, 4) of the vertices of a ``trimesh.Trimesh``, sRGB; None where it has none."""
    visual: Any = getattr(mesh, "visual", None)
    if getattr(visual, "kind", None) != "vertex":
        return None
    return np.asarray(visual.vertex_colors, dtype=np.uint8)


def _joined(vertices: FloatArray, faces: npt.NDArray[Any]) -> tuple[FloatArray, npt.NDArray[Any]]:
    """Vertices at one place made one."""
    rows = np.ascontiguousarray(vertices.astype(np.float32) + np.float32(0)).view(np.dtype((np.void, 12))).ravel()
    _, first, number = np.unique(rows, return_index=True, return_inverse=True)
    return vertices[first], number.reshape(-1)[faces]
