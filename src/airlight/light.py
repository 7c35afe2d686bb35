"""Lights, as frozen values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .errors import ValueRangeError
from .transfer import linear_rgb
from .transfer.colour import Colour
from .transfer.given import check_names, direction, finite_numbers, kind_of, not_negative, positive, set_fields

Vector = tuple[float, float, float]

VECTORS = {"head": None, "directional": "to_light", "point": "position"}
"""Kinds of lights, with the name of what tells where each comes from."""


@dataclass(frozen=True)
class Light:
    """A light; make one with ``Light.head``, ``Light.directional`` or ``Light.point``.

    Attributes
    ----------
    kind
        ``"head"``, ``"directional"`` or ``"point"``.
    vector
        Direction towards the light, of length one (directional); position in the world (point); unused (head).
    colour
        Linear ``(r, g, b)``.
    intensity
        Factor of the colour, at least 0.
    radius
        World distance at which a point light has its intensity, falling off with the square of distance; None: no fall-off.
    """

    kind: str
    vector: Vector = (0.0, 0.0, 1.0)
    colour: Vector = (1.0, 1.0, 1.0)
    intensity: float = 1.0
    radius: float | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        if self.kind not in VECTORS:
            raise ValueRangeError("light.kind", f"is {self.kind!r}, must be one of {', '.join(VECTORS)}")
        where = f"light.{VECTORS[self.kind] or 'vector'}"
        vector = direction(self.vector, where) if self.kind == "directional" else finite_numbers(self.vector, where, 3)
        colour, intensity = linear_rgb(self.colour, "light.color"), not_negative(self.intensity, "light.intensity")
        radius = None if self.radius is None else positive(self.radius, "light.radius")
        set_fields(self, vector=vector, colour=colour, intensity=intensity, radius=radius)

    @staticmethod
    def head(*, color: Colour = (1.0, 1.0, 1.0), intensity: float = 1.0) -> Light:
        """Light that comes from the eye, along each ray."""
        return Light("head", colour=linear_rgb(color, "light.color"), intensity=intensity)

    @staticmethod
    def directional(*, to_light: Vector, color: Colour = (1.0, 1.0, 1.0), intensity: float = 1.0) -> Light:
        """Light from far away; ``to_light`` is the world direction towards it, of any length."""
        return Light("directional", to_light, linear_rgb(color, "light.color"), intensity)

    @staticmethod
    def point(
        *,
        position: Vector,
        color: Colour = (1.0, 1.0, 1.0),
        intensity: float = 1.0,
        radius: float | None = None,
    ) -> Light:
        """Light at a world position, without fall-off unless ``radius`` is given."""
        return Light("point", position, linear_rgb(color, "light.color"), intensity, radius)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for scene files: the kind, and the parameters of the function of that name."""
        name = VECTORS[self.kind]
        place = {} if name is None else {name: list(self.vector)}
        radius = {} if self.radius is None else {"radius": self.radius}
        return {"kind": self.kind, **place, "color": list(self.colour), "intensity": self.intensity, **radius}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Light:
        """Return the light that ``to_dict`` wrote, or a person.

        Raises
        ------
        ValueRangeError
            For entries that are unknown, missing or not legal; it names them.
        """
        kind = kind_of(data, VECTORS, "light")
        vector = VECTORS[kind]
        known = (*([vector] if vector else []), "color", "intensity", *(["radius"] if kind == "point" else []))
        check_names(data, known, "light", kind)
        if vector is not None and vector not in data:
            raise ValueRangeError(f"light.{vector}", "is missing", f"e.g. {vector} = [0, -1, 1]")
        given = {"color": (1.0, 1.0, 1.0), **data}
        rest = {name: given[name] for name in ("intensity", "radius") if name in given}
        place = {} if vector is None else {"vector": given[vector]}
        return Light(kind, colour=linear_rgb(given["color"], "light.color"), **place, **rest)
