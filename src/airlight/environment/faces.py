"""Environments of six faces of a cube, as pictures seen from inside."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..volume import FloatArray
from .pixels import pixels_in
from .sphere import averaged

# Direction of a face's middle, and of its right and upper edge.
FACES: dict[str, tuple[tuple[int, int, int], tuple[int, int, int], tuple[int, int, int]]] = {
    "+x": ((1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "-x": ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "+y": ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
    "-y": ((0, -1, 0), (-1, 0, 0), (0, 0, 1)),
    "+z": ((0, 0, 1), (1, 0, 0), (0, -1, 0)),
    "-z": ((0, 0, -1), (1, 0, 0), (0, 1, 0)),
}


def equirectangular(faces: Mapping[str, npt.ArrayLike]) -> npt.NDArray[np.float32]:
    """Picture (2 n, 4 n, 3) of six faces (n, n, 3), whose pixels at the equator are as wide as those of the faces.

    Raises
    ------
    DataError
        When faces are missing, unknown or do not have one size.
    """
    if not isinstance(faces, Mapping):
        raise DataError("environment.faces", f"are a {type(faces).__name__}", f"give a dict of {', '.join(FACES)}")
    if set(faces) != set(FACES):
        raise DataError("environment.faces", f"are {', '.join(sorted(map(str, faces))) or 'none'}", f"give {', '.join(FACES)}")
    pictures = {name: pixels_in(face, f"environment.faces {name}", np.float64) for name, face in faces.items()}
    n = len(pictures["+x"]) if pictures["+x"].ndim else 0
    for name, face in pictures.items():
        if face.ndim != 3 or n < 1 or face.shape[:2] != (n, n) or face.shape[2] not in (3, 4):
            raise DataError(f"environment.faces {name}", f"has shape {face.shape}", "give squares (n, n, 3) of one size")

    def radiance(directions: FloatArray) -> FloatArray:
        found = np.zeros(directions.shape)
        largest = np.abs(directions).argmax(axis=-1)
        for name, (middle, right, up) in FACES.items():
            depth = directions @ np.array(middle, dtype=np.float64)
            here = (largest == np.flatnonzero(middle)[0]) & (depth > 0)
            seen = directions[here] / depth[here][:, None]
            found[here] = _linear_at(pictures[name][..., :3], seen @ np.array(right), -(seen @ np.array(up)))
        return found

    return averaged(radiance, 2 * n).astype(np.float32)


def _linear_at(face: FloatArray, aside: FloatArray, down: FloatArray) -> FloatArray:
    """Face at places (m,) in [-1, 1], bilinear between the middles of its pixels."""
    n = len(face)
    column, row = (np.clip((p + 1) / 2 * n - 0.5, 0, n - 1) for p in (aside, down))
    left, top = (np.clip(p.astype(np.int64), 0, max(n - 2, 0)) for p in (column, row))
    a, b = (column - left)[:, None], (row - top)[:, None]
    right, below = np.minimum(left + 1, n - 1), np.minimum(top + 1, n - 1)
    upper = face[top, left] * (1 - a) + face[top, right] * a
    return np.asarray(upper * (1 - b) + (face[below, left] * (1 - a) + face[below, right] * a) * b)
