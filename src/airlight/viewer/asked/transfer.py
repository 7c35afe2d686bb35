"""Transfer functions that are made by the library: peaks, colour maps; as Python, to files and from files."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from ...automatic import peak_at
from ...errors import AirlightError, FileError, ValueRangeError
from ...scene_file.reading import load_transfer
from ...transfer import TransferFunction, colormap_names
from ...transfer.colormaps import colours_of
from ...transfer.colour import PALETTE, linear_to_srgb
from ...transfer.kinds import AnyFunction
from ...transfer.opacity import extinction_from_opacity
from ..asking import answers
from ..layers import channel_in, function_in
from ..session import Session
from .probe import layer_numbered

SWATCHES = 24
PEAK_SHARE = 1 / 40
PEAK_OPACITY = 0.5
LONGEST_NAME = 200


@answers("transfer.code")
def code(session: Session, layer: int = 0) -> dict[str, str]:
    """Python that makes the layer's function again."""
    function = layer_numbered(session, layer).transfer
    assert function is not None
    return {"code": f"import airlight as al\n\ntransfer = {function.as_code()}\n"}


@answers("transfer.file")
def file(session: Session, layer: int = 0, part: int | None = None) -> dict[str, str]:
    """The text of the TOML file that keeps a function."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "transfer.toml"
        function_in(layer_numbered(session, layer), part).save(path)
        return {"name": path.name, "text": path.read_text(encoding="utf-8")}


@answers("transfer.read")
def read(session: Session, name: str, text: str) -> dict[str, Any]:
    """The function in the text of a TOML or JSON file that a user chose; errors name it as he does.

    Raises
    ------
    FileError
        When it is neither.
    """
    shown = name[-LONGEST_NAME:]
    suffix = Path(shown).suffix.lower()
    if suffix not in (".toml", ".json"):
        raise FileError(shown, "is no TOML or JSON file", "choose one that Save wrote, or airlight")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"transfer{suffix}"
        path.write_text(text, encoding="utf-8")
        try:
            return {"transfer": load_transfer(path).to_dict()}
        except AirlightError as error:
            raise type(error)(error.where.replace(str(path), shown), error.what, error.remedy) from None


@answers("transfer.peak")
def peak(
    session: Session,
    layer: int = 0,
    part: int | None = None,
    value: float | None = None,
    p_world: list[float] | None = None,
    width: float | None = None,
) -> dict[str, Any]:
    """The layer's function with a peak put on it, at a value, or as wide as the data are smooth at a point of the world."""
    shown = layer_numbered(session, layer)
    function, channel = _of_values(function_in(shown, part)), channel_in(shown, part)
    colour = PALETTE[len(function.points) // 3 % len(PALETTE)]
    if p_world is not None:
        added = peak_at(shown.volume, p_world, width, colour, channel, shown.time)
    else:
        if width is None:
            low, high = function.domain
            width = PEAK_SHARE * (high - low) or abs(low) / 100 or 1.0
        extinction = float(extinction_from_opacity(PEAK_OPACITY, min(shown.volume.spacing)))
        added = TransferFunction.peak(0.0 if value is None else value, width, colour, extinction)
    if function.associated:
        added = TransferFunction([(v, tuple(e * c for c in rgb), e) for v, rgb, e in added.points], associated=True)
    low, high = added.domain
    return {"transfer": (function | added).to_dict(), "value": (low + high) / 2}


@answers("transfer.colormap")
def colormap(session: Session, name: str, layer: int = 0, part: int | None = None, reverse: bool = False) -> dict[str, Any]:
    """The layer's function in the colours of a named map over its domain; its extinctions stay as they are."""
    function = _of_values(function_in(layer_numbered(session, layer), part))
    extinctions = [(value, extinction) for value, _, extinction in function.points]
    coloured = TransferFunction.from_colormap(name, function.domain, extinctions, reversed=reverse)
    changed = TransferFunction(coloured.points, function.associated, function.surfaces)
    return {"transfer": changed.to_dict()}


@answers("transfer.reversed")
def mirrored(session: Session, layer: int = 0, part: int | None = None) -> dict[str, Any]:
    """The layer's function with its colours in the opposite order."""
    return {"transfer": _of_values(function_in(layer_numbered(session, layer), part)).with_reversed_colours().to_dict()}


@answers("transfer.colormaps")
def colormaps(session: Session) -> dict[str, Any]:
    """Names of all colour maps, by category."""
    return {"names": {category: list(names) for category, names in colormap_names().items()}}


@answers("transfer.swatch")
def swatch(session: Session, name: str) -> dict[str, Any]:
    """Colours of a map, evenly spaced, as words for style sheets."""
    return {"colours": _swatch(name)}


@cache
def _swatch(name: str) -> list[str]:
    shares, rgb = colours_of(name)
    even = TransferFunction([(s, tuple(c), 0.0) for s, c in zip(shares.tolist(), rgb.tolist(), strict=True)])
    colours, _ = even([(n + 0.5) / SWATCHES for n in range(SWATCHES)])
    encoded = (255 * linear_to_srgb(colours)).round().astype(int).tolist()
    return ["#" + "".join(f"{c:02x}" for c in row) for row in encoded]


def _of_values(function: AnyFunction) -> TransferFunction:
    if not isinstance(function, TransferFunction):
        what = f"is a {type(function).__name__}"
        raise ValueRangeError("transfer", what, "choose a channel, or a function of one value")
    return function
