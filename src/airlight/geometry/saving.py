"""Meshes, lines and points as plain data, for scene files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..errors import DataError, ValueRangeError
from ..transfer.given import finite_numbers
from .arrays import digest
from .marks import Lines, Points
from .mesh import Mesh

MOST_POINTS = 100_000
MESH_ENTRIES = ("color", "opacity", "world_from_mesh", "smooth", "lit", "clipped")
SOLID_ENTRIES = ("file", "world_from_mesh", "smooth")
MARK_ENTRIES = ("points", "color", "colors", "opacity", "width_px", "width_world")


def to_dict(shape: Mesh | Lines | Points, where: str) -> dict[str, Any]:
    """Return plain data: a mesh by the name of its file, lines and points by their numbers.

    Raises
    ------
    DataError
        For meshes that came from no file, or whose vertices, faces or colours are no longer those of the file.
    """
    if not isinstance(shape, Mesh):
        if shape.corners_world.shape[0] > MOST_POINTS:
            raise DataError(where, f"has more than {MOST_POINTS:,} points", "keep them in a file of your own")
        found: dict[str, Any] = {"kind": "lines" if isinstance(shape, Lines) else "points"}
        return found | {name: _plain(getattr(shape, name)) for name in MARK_ENTRIES if getattr(shape, name) is not None}
    if shape.source is None:
        raise DataError(where, "came from no file", "write it to one, e.g. with trimesh, and use airlight.Mesh.open(path)")
    path, content = shape.source
    if digest(shape.vertices, shape.faces, shape.colors) != content:
        raise DataError(where, f"has changed since it was read from {path}", "write it to a file, and open that")
    return {"file": path} | {name: _plain(getattr(shape, name)) for name in MESH_ENTRIES if getattr(shape, name) is not None}


def from_dict(data: Mapping[str, Any], place: Callable[[str], str]) -> Mesh | Lines | Points:
    """Return what ``to_dict`` wrote, or a person; ``place`` finds a file that is named relative to another.

    Raises
    ------
    ValueRangeError
        For entries that are unknown or missing.
    """
    kind = data.get("kind", "mesh")
    if kind not in ("mesh", "lines", "points"):
        raise ValueRangeError("mesh.kind", f"is {kind!r}, must be one of mesh, lines, points")
    known = ("file", *MESH_ENTRIES) if kind == "mesh" else MARK_ENTRIES
    for name in data:
        if name not in ("kind", *known):
            raise ValueRangeError(f"{kind}.{name}", "is unknown", f"known here: {', '.join(known)}")
    if known[0] not in data:
        raise ValueRangeError(f"{kind}.{known[0]}", "is missing", "name a file" if kind == "mesh" else "give points")
    options = {name: value for name, value in data.items() if name not in ("kind", known[0])}
    if kind == "mesh":
        return Mesh.open(place(str(data["file"])), **options)
    return (Lines if kind == "lines" else Points)(data["points"], **options)


def solid_from_dict(data: Mapping[str, Any], place: Callable[[str], str]) -> Mesh:
    """Return the closed mesh that a clip names by its file; a matrix may be sixteen numbers, row by row.

    Raises
    ------
    ValueRangeError
        Without a file.
    """
    if not isinstance(data.get("file"), str):
        raise ValueRangeError("clip.file", "is missing", "name the file of a closed mesh")
    given = {name: value for name, value in data.items() if name != "file"}
    matrix = given.get("world_from_mesh")
    if isinstance(matrix, list | tuple) and len(matrix) == 16:
        given["world_from_mesh"] = _rows(matrix, "clip.world_from_mesh")
    return Mesh.open(place(data["file"]), **given)


def from_text(name: str, options: Mapping[str, Any]) -> Mesh:
    """Return the mesh of a file with options that were typed: a matrix is sixteen numbers, row by row.

    Raises
    ------
    ValueRangeError
        For options that are unknown.
    """
    given = dict(options)
    for option in given:
        if option not in MESH_ENTRIES:
            raise ValueRangeError(f"mesh.{option}", "is unknown", f"use {', '.join(MESH_ENTRIES)}")
    if "world_from_mesh" in given:
        given["world_from_mesh"] = _rows(given["world_from_mesh"], "mesh.world_from_mesh")
    return Mesh.open(name, **given)


def _rows(numbers: Any, where: str) -> list[tuple[float, ...]]:
    found = finite_numbers(numbers, where, 16)
    return [found[first : first + 4] for first in range(0, 16, 4)]


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
