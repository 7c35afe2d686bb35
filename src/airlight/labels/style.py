"""How a region is drawn."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ValueRangeError
from ..transfer import TransferFunction, linear_rgb, srgb_to_linear
from ..transfer.colour import MOST_COLOUR, Colour
from ..transfer.given import set_fields, share

Vector = tuple[float, float, float]

SATURATIONS, LIGHTNESSES = (0.62, 0.45, 0.78), (0.92, 0.78, 0.86, 0.68)
SHADES = len(SATURATIONS) * len(LIGHTNESSES)
HUES = 256
GREY_TAKEN = 0.8  # of a colour that stands out
GOLDEN = np.uint64(0x9E3779B97F4A7C15)  # 2^64 divided by the golden ratio


@dataclass(frozen=True)
class LabelStyle:
    """How the region of a label is drawn.

    Parameters
    ----------
    colour
        Factor of the colours that the transfer function gives, linear ``(r, g, b)`` or an sRGB word; ``"white"`` keeps them.
        None is a colour of the label's own, the same in every volume; with a ``transfer`` of its own it is white.
    opacity
        Factor of the extinction, in [0, 1].
    transfer
        Transfer function of the region instead of the layer's.

    Raises
    ------
    ValueRangeError
        For colours that are none, opacities outside of [0, 1], and what is no transfer function.
    """

    colour: Vector | None = None
    opacity: float = 1.0
    transfer: TransferFunction | None = None

    def __init__(self, colour: Colour | None = None, opacity: float = 1.0, transfer: TransferFunction | None = None) -> None:
        if transfer is not None and not isinstance(transfer, TransferFunction):
            raise ValueRangeError("label.transfer", f"is a {type(transfer).__name__}", "give a TransferFunction")
        rgb = None if colour is None else linear_rgb(colour, "label.colour", MOST_COLOUR)
        set_fields(self, colour=rgb, opacity=share(opacity, "label.opacity"), transfer=transfer)

    def tint(self, label: int) -> Vector:
        """Linear factor of the colours in the region of a label."""
        if self.colour is not None:
            return self.colour
        r, g, b = (1.0, 1.0, 1.0) if self.transfer else distinct_colours([label])[0]
        return float(r), float(g), float(b)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as scene files keep it."""
        data: dict[str, Any] = {} if self.colour is None else {"colour": list(self.colour)}
        data |= {} if self.opacity == 1 else {"opacity": self.opacity}
        return data | ({} if self.transfer is None else {"transfer": self.transfer.to_dict()})

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> LabelStyle:
        """Return the style that ``to_dict`` wrote."""
        if not isinstance(data, Mapping):
            raise ValueRangeError("label", f"is {data!r}, must be a table", "give colour, opacity and transfer")
        unknown = sorted(set(data) - {"colour", "opacity", "transfer"})
        if unknown:
            raise ValueRangeError("label", f"has unknown entries {unknown}", "use colour, opacity and transfer")
        transfer = data.get("transfer")
        if transfer is not None and not isinstance(transfer, Mapping):
            raise ValueRangeError("label.transfer", f"is {transfer!r}, must be a table with points")
        function = None if transfer is None else TransferFunction.from_dict(dict(transfer))
        return cls(data.get("colour"), data.get("opacity", 1.0), function)


def luminance(rgb: tuple[float, float, float]) -> float:
    """Brightness of a linear colour (Rec. 709)."""
    r, g, b = rgb
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def vivid(rgb: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Linear colours (..., 3) as pure and bright as a factor can be: most of their grey taken out, the greatest component 1.

    Greys become white, black stays.
    """
    purer = rgb - GREY_TAKEN * rgb.min(axis=-1, keepdims=True)
    greatest = purer.max(axis=-1, keepdims=True)
    return np.asarray(purer / np.where(greatest > 0, greatest, 1.0))


def distinct_colours(labels: Any) -> npt.NDArray[np.float64]:
    """Linear colours (n, 3) of labels: neighbours in number differ in hue by the golden angle, and in lightness.

    A label has the same colour in every volume.
    """
    ids = np.asarray(labels)
    bits = ids.astype(np.int64 if ids.dtype.kind == "i" else np.uint64).view(np.uint64)
    hue = ((bits * GOLDEN) >> np.uint64(56)).astype(np.int64)
    return _palette()[hue * SHADES + (bits % np.uint64(SHADES)).astype(np.int64)]


def _palette() -> npt.NDArray[np.float64]:
    """Colours (HUES * SHADES, 3), made once."""
    if not _PALETTE:
        encoded = [
            colorsys.hsv_to_rgb((0.03 + hue / HUES) % 1, SATURATIONS[shade % 3], LIGHTNESSES[shade % 4])
            for hue in range(HUES)
            for shade in range(SHADES)
        ]
        _PALETTE.append(srgb_to_linear(np.array(encoded)))
    return _PALETTE[0]


_PALETTE: list[npt.NDArray[np.float64]] = []
