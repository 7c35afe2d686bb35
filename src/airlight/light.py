"""Lights, as frozen values."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import DataError, ValueRangeError
from .light_image import LightImage
from .transfer import linear_rgb
from .transfer.colour import Colour
from .transfer.given import check_names, direction, finite_numbers, kind_of, not_negative, positive, set_fields

Vector = tuple[float, float, float]

VECTORS = {"head": None, "directional": "to_light", "point": "position", "spot": "position"}
"""Kinds of lights, with the name of what tells where each comes from."""

OPTIONAL = {"point": ("radius",), "spot": ("target", "angle_deg", "up", "image", "radius")}


@dataclass(frozen=True)
class Beam:
    """What a spot light throws, and where: a picture of the angle ``angle_deg`` from its top to its bottom.

    Attributes
    ----------
    target
        World point in the middle of the picture.
    angle_deg
        Angle in degrees, above 0 and below 170.
    up
        World direction that is up in the picture, not along the beam.
    image
        Factors of the light's colour; outside of it there is no light.
    """

    target: Vector
    angle_deg: float = 40.0
    up: Vector = (0.0, 0.0, 1.0)
    image: LightImage | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        target, up = finite_numbers(self.target, "light.target", 3), direction(self.up, "light.up")
        angle = positive(self.angle_deg, "light.angle_deg")
        if angle >= 170:
            raise ValueRangeError("light.angle_deg", f"is {self.angle_deg!r}, must lie in (0, 170)")
        if self.image is not None and not isinstance(self.image, LightImage):
            raise DataError("light.image", f"is a {type(self.image).__name__}", "give an array (height, width[, 3]), or a file")
        set_fields(self, target=target, up=up, angle_deg=angle)

    @property
    def picture(self) -> LightImage:
        """The picture; a soft round spot where none was given."""
        return LightImage.soft() if self.image is None else self.image


@dataclass(frozen=True)
class Light:
    """A light; make one with ``Light.head``, ``Light.directional``, ``Light.point`` or ``Light.spot``.

    Attributes
    ----------
    kind
        ``"head"``, ``"directional"``, ``"point"`` or ``"spot"``.
    vector
        Direction towards the light, of length one (directional); position in the world (point, spot); unused (head).
    colour
        Linear ``(r, g, b)``.
    intensity
        Factor of the colour, at least 0.
    radius
        World distance at which a point light has its intensity, falling off with the square of distance; None: no fall-off.
    beam
        What a spot light throws; None for all others.
    """

    kind: str
    vector: Vector = (0.0, 0.0, 1.0)
    colour: Vector = (1.0, 1.0, 1.0)
    intensity: float = 1.0
    radius: float | None = None
    beam: Beam | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        if self.kind not in VECTORS:
            raise ValueRangeError("light.kind", f"is {self.kind!r}, must be one of {', '.join(VECTORS)}")
        where = f"light.{VECTORS[self.kind] or 'vector'}"
        vector = direction(self.vector, where) if self.kind == "directional" else finite_numbers(self.vector, where, 3)
        colour, intensity = linear_rgb(self.colour, "light.color"), not_negative(self.intensity, "light.intensity")
        radius = None if self.radius is None else positive(self.radius, "light.radius")
        set_fields(self, vector=vector, colour=colour, intensity=intensity, radius=radius)
        if (self.kind == "spot") != isinstance(self.beam, Beam):
            raise ValueRangeError("light.beam", f"is {self.beam!r} for a {self.kind} light", "use Light.spot")
        if self.beam is not None:
            way = np.subtract(self.beam.target, vector)
            if np.linalg.norm(np.cross(way, self.beam.up)) <= 1e-9 * max(float(np.linalg.norm(way)), 1e-300):
                what = f"lies at {vector}, with the target {self.beam.target} and up {self.beam.up}"
                raise ValueRangeError("light.spot", what, "position and target must differ, and up must not be along the beam")

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

    @staticmethod
    def spot(
        *,
        position: Vector,
        target: Vector,
        angle_deg: float = 40.0,
        up: Vector = (0.0, 0.0, 1.0),
        image: npt.ArrayLike | str | os.PathLike[str] | LightImage | None = None,
        color: Colour = (1.0, 1.0, 1.0),
        intensity: float = 1.0,
        radius: float | None = None,
    ) -> Light:
        """Light at a world position that throws a picture towards a target, for the driver ``half_angle``.

        Parameters
        ----------
        position, target
            World points: where the light is, and what lies in the middle of its beam.
        angle_deg
            Angle of the beam from the picture's top to its bottom, degrees.
        up
            World direction that is up in the picture.
        image
            Linear factors of the light's colour (height, width) or (height, width, 3), first row on top as seen from the light,
            or a file of them (``.npy``, ``.hdr``, ``.exr``); None: a round spot with a soft edge.
        color, intensity, radius
            As of a point light.

        Raises
        ------
        DataError
            When the image is no array of numbers or of another shape.
        ValueRangeError
            For values out of range.
        """
        beam = Beam(target, angle_deg, up, _picture_of(image))
        return Light("spot", position, linear_rgb(color, "light.color"), intensity, radius, beam)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for scene files: the kind, and the parameters of the function of that name."""
        name = VECTORS[self.kind]
        place = {} if name is None else {name: list(self.vector)}
        radius = {} if self.radius is None else {"radius": self.radius}
        thrown: dict[str, Any] = {}
        if self.beam is not None:
            thrown = {"target": list(self.beam.target), "angle_deg": self.beam.angle_deg, "up": list(self.beam.up)}
            thrown |= {} if self.beam.image is None else {"image": self.beam.image.to_dict()}
        return {"kind": self.kind, **place, **thrown, "color": list(self.colour), "intensity": self.intensity, **radius}

    @staticmethod
    def from_dict(data: Mapping[str, Any], place: Callable[[str], str] = str) -> Light:
        """Return the light that ``to_dict`` wrote, or a person; ``place`` finds the file of a picture by its name.

        Raises
        ------
        ValueRangeError
            For entries that are unknown, missing or not legal; it names them.
        """
        kind = kind_of(data, VECTORS, "light")
        vector = VECTORS[kind]
        known = (*([vector] if vector else []), "color", "intensity", *OPTIONAL.get(kind, ()))
        check_names(data, known, "light", kind)
        for name in (*([vector] if vector else []), *(["target"] if kind == "spot" else [])):
            if name not in data:
                raise ValueRangeError(f"light.{name}", "is missing", f"e.g. {name} = [0, -1, 1]")
        given = {"color": (1.0, 1.0, 1.0), **data}
        rest: dict[str, Any] = {name: given[name] for name in ("intensity", "radius") if name in given}
        if kind == "spot":
            thrown = {name: given[name] for name in ("target", "angle_deg", "up") if name in given}
            rest["beam"] = Beam(**thrown, image=_named_picture(given.get("image"), place))
        where = {} if vector is None else {"vector": given[vector]}
        return Light(kind, colour=linear_rgb(given["color"], "light.color"), **where, **rest)


def _picture_of(image: Any) -> LightImage | None:
    if image is None or isinstance(image, LightImage):
        return image
    return LightImage.open(image) if isinstance(image, (str, os.PathLike)) else LightImage(image)


def _named_picture(given: Any, place: Callable[[str], str]) -> LightImage | None:
    """Picture in a file, named alone or in a table."""
    name = given.get("file") if isinstance(given, Mapping) else given
    if name is None:
        return None
    if not isinstance(name, str):
        raise DataError("light.image", f"is {given!r}", "name a .npy, .hdr or .exr file")
    return LightImage.open(place(name))
