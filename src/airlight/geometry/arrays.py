"""Arrays of points, faces and colours, checked and made read-only."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..transfer.colour import srgb_to_linear
from ..volume import FloatArray

IndexArray = npt.NDArray[np.uint32]


def points_of(given: Any, where: str) -> FloatArray:
    """Points (n, 3), float64.

    Raises
    ------
    DataError
        When they are none, or not finite.
    """
    points = _numbers(given, where, "give points as an array (n, 3)")
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise DataError(where, f"has the shape {points.shape}", "give points as an array (n, 3)")
    check_finite(points, where)
    return frozen(points, np.float64)


def check_finite(points: FloatArray, where: str) -> None:
    """Refuse points with NaN or infinity.

    Raises
    ------
    DataError
        Tells how many there are, and the first.
    """
    bad = ~np.isfinite(points).all(axis=-1)
    if bad.any():
        raise DataError(
            where, f"has {int(bad.sum())} points that are not finite, the first is {int(np.argmax(bad))}", "mend it"
        )


def faces_of(given: Any, vertex_count: int, where: str) -> IndexArray:
    """Faces (m, 3), uint32: the numbers of the three vertices of each.

    Raises
    ------
    DataError
        When there are none, they are no triangles, or name vertices that are not there.
    """
    faces = array_of(given, where, "give whole numbers (m, 3): three vertices a face")
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
        what = f"is an array of {faces.dtype} with the shape {faces.shape}"
        raise DataError(where, what, "give whole numbers (m, 3): three vertices a face")
    if not len(faces):
        raise DataError(where, "is empty", "a mesh has at least one face; draw loose points with airlight.Points")
    least, greatest = int(faces.min()), int(faces.max())
    if least < 0 or greatest >= vertex_count:
        wrong = least if least < 0 else greatest
        raise DataError(where, f"names vertex {wrong}", f"there are {vertex_count}, numbered from 0 to {vertex_count - 1}")
    return frozen(faces, np.uint32)


def colours_of(given: Any, count: int, where: str) -> FloatArray:
    """Linear colours with opacity (count, 4), float64, of rgb or rgba: numbers are linear, bytes (uint8) are sRGB.

    Raises
    ------
    DataError
        When there are not as many as wanted, or they lie outside of what is allowed.
    """
    found = _numbers(given, where, "give an array (n, 3) or (n, 4)")
    if found.shape not in ((count, 3), (count, 4)):
        raise DataError(where, f"has the shape {found.shape}", f"give ({count}, 3) or ({count}, 4)")
    if np.asarray(given).dtype == np.uint8:
        unit = found / 255
        found = np.concatenate([srgb_to_linear(unit[:, :3]), unit[:, 3:]], axis=1)
    if found.shape[1] == 3:
        found = np.concatenate([found, np.ones((count, 1))], axis=1)
    if not np.isfinite(found).all() or found.min() < 0 or found[:, 3].max() > 1:
        raise DataError(where, "has values that are not finite, below 0, or opacities above 1", "give linear colours")
    return frozen(found, np.float64)


def frozen(array: npt.NDArray[Any], dtype: Any) -> npt.NDArray[Any]:
    """Read-only array of a type; one that is that already stays itself, so that the device finds it again."""
    if array.dtype == dtype and array.flags.c_contiguous and array.flags.owndata and not array.flags.writeable:
        return array
    made = np.array(array, dtype=dtype, order="C")
    made.flags.writeable = False
    return made


def digest(*arrays: npt.NDArray[Any] | None) -> str:
    """Digest of what arrays hold, by which they are compared."""
    found = hashlib.blake2b(digest_size=16)
    for array in arrays:
        found.update(repr(None if array is None else array.shape).encode())
        if array is not None:
            found.update(array.data)
    return found.hexdigest()


def array_of(given: Any, where: str, remedy: str) -> npt.NDArray[Any]:
    """Array of real numbers.

    Raises
    ------
    DataError
        When it is none.
    """
    try:
        array = np.asarray(given)
    except (TypeError, ValueError):
        array = np.empty(0, dtype=object)  # rows of different lengths
    if array.dtype.kind not in "biuf":
        raise DataError(where, f"is a {type(given).__name__} that is no array of numbers", remedy)
    return array


def _numbers(given: Any, where: str, remedy: str) -> FloatArray:
    return array_of(given, where, remedy).astype(np.float64, copy=False)
