"""Environments: light from all directions, as a value."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError, ValueRangeError
from ..transfer.colour import Colour, linear_rgb
from ..transfer.given import direction, finite
from ..volume import FloatArray
from .pixels import pixels_in
from .sources import Picture, Sky, Source, Studio, Vector, White

Opener = Callable[[str], "Environment"]  # of a picture in a file

BUILT_IN: dict[str, type[White | Sky | Studio]] = {"white": White, "sky": Sky, "studio": Studio}


@dataclass(frozen=True)
class Environment:
    """Light that comes from all directions, from far away; as light, as background, or as both.

    Make one with ``Environment.studio``, ``sky``, ``white``, ``open``, ``from_picture`` or ``from_faces``. Directions are those
    of the world: up is +z (superior), and the middle of a picture lies at +y, where the view ``front`` looks.

    Attributes
    ----------
    source
        What makes its picture.
    turn
        How it is turned in the world: a rotation vector, the axis times the angle in radians.
    """

    source: Source
    turn: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check the source and the turn."""
        if not callable(getattr(self.source, "picture", None)):
            remedy = "use Environment.studio, sky, white, open, from_picture or from_faces"
            raise DataError("environment.source", f"is {self.source!r}, no source of light", remedy)
        if np.shape(self.turn) != (3,):
            raise ValueRangeError("environment.turn", f"is {self.turn!r}", "give three numbers: the axis times radians")
        x, y, z = (finite(c, "environment.turn") for c in self.turn)
        object.__setattr__(self, "turn", (x, y, z))

    @staticmethod
    def white(color: Colour = (1.0, 1.0, 1.0)) -> Environment:
        """Return the same light from everywhere, of a linear or named colour: the furnace of furnace tests."""
        return Environment(White(linear_rgb(color, "environment.white.color")))

    @staticmethod
    def studio(*, key: float = 1.0, fill: float = 1.0, rim: float = 1.0, room: float = 1.0) -> Environment:
        """Return three soft boxes in a grey room, placed for the view ``front``; numbers are factors of their strength.

        The key light stands high on the viewer's left, the fill light on the right, the rim light behind and above.
        """
        return Environment(Studio(key, fill, rim, room))

    @staticmethod
    def sky(
        *,
        to_sun: Vector = (-0.45, -0.6, 0.66),
        turbidity: float = 3.0,
        sun: float = 2.0,
        ground: Colour = (0.25, 0.22, 0.2),
    ) -> Environment:
        """Return daylight, after Preetham, Shirley and Smits 1999; a white surface that faces the zenith is white.

        Parameters
        ----------
        to_sun
            World direction towards the sun, z at least 0.
        turbidity
            Haze, 1.7 (very clear) to 10.
        sun
            Irradiance of the sun on a surface that faces it, over that of the sky on level ground; 0 leaves the disc out.
        ground
            Albedo of the ground, linear or a name.
        """
        return Environment(Sky(to_sun, turbidity, sun, linear_rgb(ground, "environment.sky.ground")))

    @staticmethod
    def from_picture(pixels: npt.ArrayLike) -> Environment:
        """Return the environment of an equirectangular picture.

        Parameters
        ----------
        pixels
            Linear Rec. 709 radiance (h, 2 h, 3), any number type; a fourth channel is left out. The first row is the zenith,
            +z; the middle column +y; +x a quarter to the right of it, as one sees it from inside.

        Raises
        ------
        DataError
            For other shapes, and radiance that is negative, no number, or above 1e9.
        """
        return Environment(Picture(pixels_in(pixels, "environment")))

    @staticmethod
    def from_faces(faces: Mapping[str, npt.ArrayLike]) -> Environment:
        """Return the environment of six square pictures (n, n, 3), seen from inside a cube; see ``environment.faces``.

        Keys are the directions ``"+x" "-x" "+y" "-y" "+z" "-z"``. Faces round the horizon have +z at their upper edge; ``"+z"``
        has +y at its lower edge and ``"-z"`` at its upper one, as one sees them by leaning back or forward from looking to +y.

        Raises
        ------
        DataError
            When faces are missing or do not have one size.
        """
        from .faces import equirectangular

        return Environment(Picture(equirectangular(faces)))

    @staticmethod
    def open(path: str | os.PathLike[str], *, max_memory: int = 2 << 30, untrusted: bool = False) -> Environment:
        """Return the environment of an equirectangular picture in a ``.hdr``, ``.exr`` or ``.npy`` file.

        Parameters
        ----------
        path
            The file.
        max_memory
            Bytes that its pixels may take as float32.
        untrusted
            Read in a process of its own with limits on memory and time.

        Raises
        ------
        FileError
            When the file cannot be read or is of another kind.
        MissingExtraError
            For ``.hdr`` without imagecodecs and ``.exr`` without OpenEXR.
        DataError
            When the picture is not equirectangular, or its radiance is negative or no number.
        LimitError
            For more than ``max_memory``, and more than 2^27 pixels.
        """
        from .reading import read_picture

        if not isinstance(path, (str, os.PathLike)):
            raise DataError("environment.open.path", f"is {path!r}", "name a .hdr, .exr or .npy file")
        place = Path(path)
        if untrusted:
            from ..io.options import ReadOptions
            from ..io.untrusted import read_untrusted_picture

            pixels = read_untrusted_picture(place, ReadOptions(max_bytes=max_memory))
        else:
            pixels = read_picture(place, max_memory)
        return Environment(Picture(pixels, os.path.abspath(place)))

    def turned(self, angle_rad: float, axis: Vector = (0.0, 0.0, 1.0)) -> Environment:
        """Return it turned about a world axis, counterclockwise as seen against the axis; its maps stay as they are.

        Parameters
        ----------
        angle_rad
            Angle in radians.
        axis
            World direction of the axis, of any length.

        Raises
        ------
        ValueRangeError
            When the angle is not finite or the axis no direction.
        """
        angle = finite(angle_rad, "environment.turned.angle_rad")
        turn = angle * np.array(direction(axis, "environment.turned.axis"))
        x, y, z = rotation_vector(rotation_matrix(turn) @ rotation_matrix(np.asarray(self.turn)))
        return replace(self, turn=(x, y, z))

    def __repr__(self) -> str:
        if isinstance(self.source, Picture):
            made = f"Environment({self.source!r})"
        else:
            plain = BUILT_IN[self.source.kind]()
            values = [(name, getattr(self.source, name), getattr(plain, name)) for name in plain.__dataclass_fields__]
            given = ", ".join(f"{name}={value!r}" for name, value, default in values if value != default)
            made = f"Environment.{self.source.kind}({given})"
        angle = math.hypot(*self.turn)
        if angle == 0:
            return made
        axis = ", ".join(f"{c / angle:.4g}" for c in self.turn)
        return f"{made}.turned({angle:.4g}, ({axis}))"

    @property
    def environment_from_world(self) -> FloatArray:
        """Matrix (3, 3) from directions of the world to those of the picture."""
        return rotation_matrix(np.asarray(self.turn)).T

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, for scene files.

        Raises
        ------
        DataError
            When its picture came from no file.
        """
        turn = {"turn": list(self.turn)} if any(self.turn) else {}
        return {"kind": self.source.kind} | self.source.to_dict() | turn

    @staticmethod
    def named(text: str, opened: Opener | None = None) -> Environment:
        """Return a built-in environment by its name, or that of a picture in a file, which ``opened`` opens."""
        return Environment(BUILT_IN[text]()) if text in BUILT_IN else (opened or Environment.open)(text)

    @staticmethod
    def from_dict(data: Mapping[str, Any], opened: Opener | None = None) -> Environment:
        """Return the environment of plain data: a ``kind`` with its parameters, or a ``file``, which ``opened`` opens.

        Raises
        ------
        ValueRangeError
            For unknown kinds and parameters, and values out of range.
        """
        values = dict(data)
        turn, kind = values.pop("turn", (0.0, 0.0, 0.0)), values.pop("kind", "picture" if "file" in data else None)
        turn = tuple(turn) if isinstance(turn, list) else turn
        known = ", ".join((*BUILT_IN, "picture"))
        if kind not in (*BUILT_IN, "picture"):
            raise ValueRangeError("environment.kind", f"is {kind!r}, must be one of {known}")
        names = ("file",) if kind == "picture" else tuple(BUILT_IN[kind].__dataclass_fields__)
        for name in values:
            if name not in names:
                known = ", ".join((*names, "turn"))
                raise ValueRangeError(f"environment.{name}", f"is no parameter of {kind}", f"it has {known}")
        if kind != "picture":
            plain: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
            return Environment(BUILT_IN[kind](**plain), turn)
        if not isinstance(values.get("file"), str):
            raise DataError("environment.file", "is missing", "name a .hdr, .exr or .npy file")
        return replace((opened or Environment.open)(values["file"]), turn=turn)


def rotation_matrix(turn: FloatArray) -> FloatArray:
    """Matrix (3, 3) of a rotation vector, by Rodrigues' formula."""
    angle = float(np.linalg.norm(turn))
    if angle == 0:
        return np.eye(3)
    x, y, z = turn / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k))


def rotation_vector(matrix: FloatArray) -> FloatArray:
    """Rotation vector (3,) of a matrix, of an angle of at most pi, by way of the quaternion with the largest part first."""
    m = matrix
    squares = np.array([np.trace(m), m[0, 0], m[1, 1], m[2, 2]])
    largest = int(squares.argmax())
    antisymmetric = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    if largest == 0:
        quaternion = np.concatenate([[1 + squares[0]], antisymmetric])
    else:
        axis = largest - 1
        parts = m[axis] + m[:, axis]
        parts[axis] = 1 + 2 * m[axis, axis] - squares[0]
        quaternion = np.concatenate([[antisymmetric[axis]], parts])
    quaternion /= np.linalg.norm(quaternion) * (-1 if quaternion[0] < 0 else 1)
    sine = float(np.linalg.norm(quaternion[1:]))
    if sine < 1e-300:
        return np.zeros(3)
    return np.asarray(quaternion[1:] * (2 * math.atan2(sine, quaternion[0]) / sine))
