"""Where rays meet triangles."""

from __future__ import annotations

import numpy as np

from ..volume import FloatArray


def intersections(triangles: FloatArray, origin: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (n, m) at which rays meet triangles (m, 3, 3), inf where they do not, and shares (n, m, 3) of the corners.

    With edges b and c from the corner a, the point ``a + v b + w c`` of the plane lies on the ray where ``v b + w c - t d =
    o - a``; Cramer's rule gives v, w and t as quotients of volumes (Moeller and Trumbore 1997).
    """
    a, b, c = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    d = direction[:, None]
    from_a = origin[:, None] - a
    across = np.cross(d, c)
    volume = (b * across).sum(axis=-1)
    safe = np.where(volume == 0, 1.0, volume)
    other = np.cross(from_a, b)
    v = (from_a * across).sum(axis=-1) / safe
    w = (d * other).sum(axis=-1) / safe
    t = (c * other).sum(axis=-1) / safe
    meets = (volume != 0) & (v >= 0) & (w >= 0) & (v + w <= 1) & (t > 0)
    return np.where(meets, t, np.inf), np.stack([1 - v - w, v, w], axis=-1)
