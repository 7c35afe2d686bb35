"""What is typed behind options, made into values; each error names its option."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

from .. import stages as _stages  # noqa: F401  (makes the names of the stages known)
from ..errors import ValueRangeError
from ..scene import VIEWS, Camera
from ..scene_file import load_transfer, stage_from_values
from ..stage import STAGES, Stage
from ..transfer import Surface, TransferFunction, linear_rgb
from ..transfer.colour import PALETTE
from ..transfer.kinds import AnyFunction
from ..transfer.surfaces import checked_surfaces

UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}


def parse_size(text: str) -> tuple[int, int]:
    """Width and height in pixels of ``640x480``, or ``512`` for a square."""
    match = re.fullmatch(r"(\d{1,6})(?:\s*[xX×,]\s*(\d{1,6}))?", text.strip())
    if not match or not int(match[1]) or not int(match[2] or match[1]):
        raise ValueRangeError("--size", f"is {text!r}, must be WIDTHxHEIGHT", "e.g. --size 640x480")
    return int(match[1]), int(match[2] or match[1])


def parse_bytes(text: str, where: str = "--max-memory") -> int:
    """Bytes of ``4G``, ``500M`` or ``1048576``; units are powers of 1024."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([kmgt]?)(?:i?b)?", text.strip().lower())
    if not match or float(match[1]) <= 0:
        raise ValueRangeError(where, f"is {text!r}, must be a size", "e.g. 4G or 500M")
    return int(float(match[1]) * UNITS[match[2]])


def parse_numbers(text: str, counts: tuple[int, ...], where: str) -> list[float]:
    """Finite numbers between commas, as many as one of ``counts``."""
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(math.isfinite(n) for n in numbers):
        raise ValueRangeError(where, f"is {text!r}, must be {' or '.join(map(str, counts))} numbers with commas between")
    return numbers


def parse_shape(text: str) -> tuple[int, ...]:
    """Number of voxels ``x,y,z`` (and channels, and times) of a raw file; ``x`` may stand between them, too."""
    words = re.split(r"\s*[x,×]\s*", text.strip())
    if not 3 <= len(words) <= 5 or not all(word.isdecimal() and int(word) for word in words):
        raise ValueRangeError("--shape", f"is {text!r}, must be three to five whole numbers", "e.g. --shape 256x256x128")
    return tuple(int(word) for word in words)


def parse_spacing(text: str) -> tuple[float, float, float]:
    """World size ``x,y,z`` of a voxel; one number for all three."""
    numbers = parse_numbers(text, (1, 3), "--spacing")
    x, y, z = numbers * 3 if len(numbers) == 1 else numbers
    if min(x, y, z) <= 0:
        raise ValueRangeError("--spacing", f"is {text!r}, must be above 0")
    return x, y, z


def parse_background(text: str) -> tuple[float, float, float] | None:
    """Linear colour of a CSS word, ``#rrggbb`` or three linear numbers; None for ``none``."""
    if text == "none":
        return None
    if re.match(r"[\d.]", text):
        r, g, b = parse_numbers(text, (3,), "--background")
        return linear_rgb((r, g, b), "--background")
    return linear_rgb(text, "--background")


def parse_camera(text: str) -> Camera | str:
    """Name of a view, or a camera at ``ex,ey,ez`` that looks to ``tx,ty,tz``, with up ``ux,uy,uz`` behind them if given.

    Cameras of other kinds are stages with parameters, of which ``eye`` and ``target`` must be told.
    """
    if text in VIEWS:
        return text
    kind, _, rest = (part.strip() for part in text.partition(":"))
    if kind in STAGES["camera"]:
        values = assignments(rest, "--camera") if rest else {}
        if not {"eye", "target"} <= values.keys():
            example = f"e.g. {kind}:eye=[0,0,0],target=[0,1,0]"
            raise ValueRangeError("--camera", f"is {text!r}, must tell eye and target", example)
        camera = stage_from_values("camera", kind, values, "--camera")
        assert isinstance(camera, Camera)
        return camera
    if not re.match(r"[\s\d.+-]", text):
        kinds = "a kind with parameters as panorama:eye=[0,0,0],target=[0,1,0]"
        raise ValueRangeError("--camera", f"is {text!r}, must be one of {', '.join(VIEWS)}, ex,ey,ez,tx,ty,tz, or {kinds}")
    numbers = parse_numbers(text, (6, 9), "--camera")
    (ex, ey, ez), (tx, ty, tz), up = numbers[:3], numbers[3:6], numbers[6:]
    if not up:
        # Looking straight up or down: as the views top and bottom do.
        vertical = math.hypot(tx - ex, ty - ey) < 1e-6 * abs(tz - ez)
        up = [0.0, -1.0, 0.0] if vertical else [0.0, 0.0, 1.0]
    return Camera.perspective(eye=(ex, ey, ez), target=(tx, ty, tz), up=(up[0], up[1], up[2]))


def parse_transfer(text: str) -> AnyFunction:
    """Transfer function in a file, or ``value:colour:extinction`` triples with spaces between."""
    if text.lower().endswith((".toml", ".json")):
        return load_transfer(text)
    points = []
    for word in text.split():
        parts = word.split(":")
        if len(parts) != 3:
            example = 'e.g. --tf "0:black:0 300:#ffaa88:0.02 1200:white:0.5"'
            raise ValueRangeError("--tf", f"has {word!r}, must be VALUE:COLOUR:EXTINCTION or the name of a file", example)
        try:
            value, extinction = float(parts[0]), float(parts[2])
        except ValueError:
            raise ValueRangeError("--tf", f"has {word!r}, whose value and extinction must be numbers") from None
        colour = parse_numbers(parts[1], (3,), "--tf") if "," in parts[1] else parts[1]
        points.append((value, colour, extinction))
    return TransferFunction(points)


def parse_channels(text: str) -> dict[int | str, tuple[float, float, float] | None] | None:
    """Channels, by number or name, with their linear colours, of ``0=green,1=magenta``; a colour may be left out.

    None for ``all``.
    """
    if text.strip() == "all":
        return None
    found: dict[int | str, tuple[float, float, float] | None] = {}
    for word in text.split(","):
        name, equals, colour = (part.strip() for part in word.rpartition("=")) if "=" in word else (word.strip(), "", "")
        if not name or (equals and not colour):
            found_text = f"is {text!r}, must be all, or CHANNEL=COLOUR"
            raise ValueRangeError("--channels", found_text, "e.g. --channels 0=green,1=magenta")
        channel = int(name) if name.isdecimal() else name
        if channel in found:
            raise ValueRangeError("--channels", f"names {name} twice")
        found[channel] = linear_rgb(colour, f"--channels {name}") if colour else None
    return found


def parse_iso(texts: Sequence[str]) -> tuple[Surface, ...]:
    """Surfaces of equal value of ``value:colour:opacity:back colour:back opacity``, all but the value may be left out.

    Those without a colour get one of seven that all eyes tell apart.
    """
    surfaces = []
    for number, text in enumerate(texts):
        value, colour, opacity, back_colour, back_opacity = (*text.split(":"), *[""] * 5)[:5]
        if text.count(":") > 4:
            found = f"is {text!r}, must be VALUE:COLOUR:OPACITY:BACK-COLOUR:BACK-OPACITY"
            raise ValueRangeError("--iso", found, "e.g. --iso 300:gold:0.5")
        numbers = [_number(word, text) for word in (value, opacity or "1", back_opacity or "nan")]
        colours = [
            tuple(parse_numbers(word, (3,), "--iso")) if "," in word else word
            for word in (colour or PALETTE[number % len(PALETTE)], back_colour)
        ]
        with renamed(f"--iso {text}"):
            back = None if math.isnan(numbers[2]) else numbers[2]
            surfaces.append(Surface(numbers[0], colours[0], numbers[1], colours[1] or None, back))
    with renamed("--iso"):
        return checked_surfaces(surfaces)


def _number(word: str, text: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise ValueRangeError("--iso", f"is {text!r}, whose value and opacities must be numbers") from None


@contextlib.contextmanager
def renamed(option: str) -> Iterator[None]:
    """Let errors of what was typed name its option."""
    try:
        yield
    except ValueRangeError as error:
        raise ValueRangeError(option, error.what, error.remedy) from None


def parse_stage(slot: str, text: str, option: str = "") -> Stage:
    """Stage of ``name`` or ``name:parameter=value,parameter=value``; lists in brackets. Without ``option`` it is the slot's."""
    name, colon, rest = text.partition(":")
    where = f"--{option or slot}"
    return stage_from_values(slot, name.strip(), assignments(rest, where) if colon else {}, where)


def choices(slot: str) -> str:
    """Words for a help text: the stages of a slot."""
    return ", ".join(sorted(STAGES[slot]))


def assignments(text: str, where: str) -> dict[str, Any]:
    """Values by name of ``parameter=value,parameter=value``; lists in brackets."""
    values: dict[str, Any] = {}
    for word in _words(text):
        key, equals, value = (part.strip() for part in word.partition("="))
        if not equals or not key or not value:
            raise ValueRangeError(where, f"has {word!r}, must be PARAMETER=VALUE", f"e.g. {where} name:parameter=1")
        if key in values:
            raise ValueRangeError(f"{where}.{key}", "is given twice")
        values[key] = _literal(value)
    return values


def _words(text: str) -> Iterator[str]:
    """Parts between the commas that lie in no bracket."""
    begin = depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "[") - (letter == "]")
        if letter == "," and depth <= 0:
            yield text[begin:place]
            begin = place + 1
    yield text[begin:]


def _literal(text: str) -> Any:
    """Number, true or false, or list, as TOML writes them; anything else is text."""
    import tomllib

    number = re.fullmatch(r"([+-]?)(\.?\d.*|\d+\.)", text)  # TOML wants digits round the point
    candidates = (
        [text, f"{number[1]}0{number[2]}" if number and number[2].startswith(".") else f"{text}0"] if number else [text]
    )
    for candidate in candidates:
        try:
            return tomllib.loads(f"v = {candidate}")["v"] if "\n" not in candidate else candidate
        except tomllib.TOMLDecodeError:
            continue
    return text
