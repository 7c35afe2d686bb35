"""Where an environment comes from: a picture, or one of the built-in ones, as frozen values that make a picture."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Protocol

import numpy as np
import numpy.typing as npt

from ..errors import DataError, ValueRangeError
from ..transfer.colour import linear_rgb
from ..transfer.given import direction, finite
from . import sky, studio
from .pixels import KnownByPixels

Vector = tuple[float, float, float]
Picture32 = npt.NDArray[np.float32]

ROWS = 512
MOST_ROWS = 8192
GREATEST_RADIANCE = 1e9


class Source(Protocol):
    """What makes the picture of an environment; equal sources make equal pictures."""

    kind: ClassVar[str]

    def picture(self) -> Picture32:
        """Radiance, linear Rec. 709, equirectangular float32 (h, w, 3); see ``environment.sphere``."""
        ...

    def to_dict(self) -> dict[str, Any]:
        """Return the parameters as plain data."""
        ...

    def __hash__(self) -> int: ...


@lru_cache(maxsize=4)
def picture_of(source: Source) -> Picture32:
    """Return the picture of a source, made once and not to be written."""
    pixels = source.picture()
    pixels.setflags(write=False)
    return pixels


class _Analytic:
    """Base of the built-in sources: their parameters are numbers."""

    def to_dict(self) -> dict[str, Any]:
        """Return the parameters as plain data."""
        values = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}  # type: ignore[arg-type]
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


@dataclass(frozen=True)
class White(_Analytic):
    """The same light from everywhere."""

    kind: ClassVar[str] = "white"
    color: Vector = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Check the colour."""
        object.__setattr__(self, "color", linear_rgb(self.color, "environment.white.color"))

    def picture(self) -> Picture32:
        """Radiance, float32 (2, 4, 3)."""
        return np.full((2, 4, 3), self.color, dtype=np.float32)


@dataclass(frozen=True)
class Sky(_Analytic):
    """Clear or hazy daylight over a ground; see ``environment.sky``."""

    kind: ClassVar[str] = "sky"
    to_sun: Vector = (-0.45, -0.6, 0.66)
    turbidity: float = 3.0
    sun: float = 2.0
    ground: Vector = (0.25, 0.22, 0.2)

    def __post_init__(self) -> None:
        """Check the parameters; the direction gets length one."""
        where = "environment.sky"
        to_sun = direction(self.to_sun, f"{where}.to_sun")
        if to_sun[2] < 0:
            raise ValueRangeError(f"{where}.to_sun", f"is {self.to_sun!r}, must be at or above the horizon, z >= 0")
        object.__setattr__(self, "to_sun", to_sun)
        for name, low, high in (("turbidity", 1.7, 10.0), ("sun", 0.0, 1e3)):
            value = finite(getattr(self, name), f"{where}.{name}")
            if not low <= value <= high:
                raise ValueRangeError(f"{where}.{name}", f"is {value}, must lie in [{low:g}, {high:g}]")
            object.__setattr__(self, name, value)
        object.__setattr__(self, "ground", linear_rgb(self.ground, f"{where}.ground"))

    def picture(self) -> Picture32:
        """Radiance, float32 (512, 1024, 3)."""
        return sky.picture(self.to_sun, self.turbidity, self.sun, self.ground, ROWS)


@dataclass(frozen=True)
class Studio(_Analytic):
    """Soft boxes in a grey room; see ``environment.studio``."""

    kind: ClassVar[str] = "studio"
    key: float = 1.0
    fill: float = 1.0
    rim: float = 1.0
    room: float = 1.0

    def __post_init__(self) -> None:
        """Check the strengths."""
        for field in dataclasses.fields(self):
            where = f"environment.studio.{field.name}"
            value = finite(getattr(self, field.name), where)
            if not 0 <= value <= 1e3:
                raise ValueRangeError(where, f"is {value}, must lie in [0, 1000]")
            object.__setattr__(self, field.name, value)

    def picture(self) -> Picture32:
        """Radiance, float32 (512, 1024, 3)."""
        return studio.picture(self.key, self.fill, self.rim, self.room, ROWS)


@dataclass(frozen=True, eq=False)
class Picture(KnownByPixels):
    """An equirectangular picture; equal to another of equal content."""

    kind: ClassVar[str] = "picture"
    where: ClassVar[str] = "environment"
    opener: ClassVar[str] = "Environment.open"
    pixels: Picture32
    path: str | None = None

    def __post_init__(self) -> None:
        """Check the pixels and keep a copy that cannot be written.

        Raises
        ------
        DataError
            For shapes that are no colour picture, for radiance that is negative, too large or no number.
        """
        where = f"environment {self.path}" if self.path else "environment"
        pixels = np.asarray(self.pixels)
        if pixels.dtype.kind not in "fiub" or pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or min(pixels.shape[:2]) < 2:
            found = f"is {pixels.dtype} of shape {pixels.shape}"
            raise DataError(where, found, "pass linear radiance (height, width, 3), twice as wide as high")
        height, width = pixels.shape[:2]
        if width != 2 * height:
            remedy = "an equirectangular picture shows all directions; resize it, or use Environment.from_faces"
            raise DataError(where, f"is {width} x {height} pixels, must be twice as wide as high", remedy)
        if height > MOST_ROWS:
            raise DataError(where, f"has {height} rows, at most {MOST_ROWS} are kept", "reduce it")
        copy = np.array(pixels[..., :3], dtype=np.float32)
        if not (np.isfinite(copy).all() and float(copy.min()) >= 0 and float(copy.max()) <= GREATEST_RADIANCE):
            raise DataError(where, f"holds radiance that is no number, negative or above {GREATEST_RADIANCE:g}", "mend it")
        copy.setflags(write=False)
        object.__setattr__(self, "pixels", copy)

    def picture(self) -> Picture32:
        """Return the pixels."""
        return self.pixels
