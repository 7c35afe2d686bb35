"""The spacing that the user gives for files that cannot tell theirs, and how a scene file remembers it."""

from __future__ import annotations

Spacing = tuple[float, float, float]


def recipe(spacing: Spacing | None) -> tuple[tuple[str, str], ...]:
    """What must be told again to read the file again, for ``Source.options``."""
    return () if spacing is None else (("spacing", " ".join(repr(float(s)) for s in spacing)),)
