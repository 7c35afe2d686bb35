"""Joint histograms of a volume: where its samples lie along, in the plane or in the space of one, two or three variables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..errors import FileError, ValueRangeError
from ..volume import FloatArray, Volume
from .derivatives import Piece, piece, places
from .joint_axes import VARIABLES, Axis, channel_of, check_axes, check_variable

if TYPE_CHECKING:
    from .function import TransferFunction
    from .joint import JointFunction

Progress = Callable[[str, int, int], None]

PERCENTILES = (0.01, 99.99)
SAMPLES_FOR_AXES = 1 << 23
SAMPLES_FOR_QUANTUM = 1 << 18
LEAST_MULTIPLES, MOST_MULTIPLES = 16, 8192
BINS = {1: 256, 2: 256, 3: 64}
MOST_BINS = {1: 4096, 2: 4096, 3: 512}


@dataclass(frozen=True, eq=False)
class JointHistogram:
    """Counts of samples by one, two or three variables.

    Attributes
    ----------
    counts
        ``(n,)``, ``(n, n)`` or ``(n, n, n)`` int64; the last axis is the first variable's, as in tables of `JointFunction`.
    axes
        The variables; bins divide each from low to high evenly.
    outside
        Number of samples beyond the axes. Together with the counts: all samples that are not empty.
    empty
        Number of samples that are NaN, infinite or no-data, in any of the variables.
    units
        Units of the variables, as text; empty where the volume does not tell them.
    """

    counts: npt.NDArray[np.int64]
    axes: tuple[Axis, ...]
    outside: int
    empty: int
    units: tuple[str, ...] = ()

    @property
    def bins(self) -> int:
        """Number of bins along each axis."""
        return int(self.counts.shape[-1])

    def edges(self, axis: int) -> FloatArray:
        """Ends (n + 1,) of the bins along an axis."""
        return np.linspace(self.axes[axis].low, self.axes[axis].high, self.bins + 1)

    def image(self, first: int = 0, second: int = 1) -> npt.NDArray[np.uint8]:
        """Picture ``(n, n)`` of the logarithm of the counts, 0 where there is none, 255 for the greatest.

        One axis runs to the right, the other upward: the first row is its highest bin. A third one is summed over.
        """
        k = len(self.axes)
        if k == 1:
            raise ValueRangeError("image", "is of two variables, and the histogram has one", "use picture")
        if {first, second} - set(range(k)) or first == second:
            raise ValueRangeError("image", f"is of axes {first} and {second}", f"choose two different ones of 0 to {k - 1}")
        counts = self.counts.T
        plane = counts.sum(axis=tuple({0, 1, 2}.difference({first, second}) if k == 3 else ()))
        upward = plane.T if first < second else plane
        shade = np.log1p(upward[::-1].astype(np.float64))
        return np.asarray(np.rint(255 * shade / max(float(shade.max()), 1e-300)), dtype=np.uint8)

    def picture(self, function: JointFunction | TransferFunction | None = None) -> npt.NDArray[np.uint8]:
        """Picture ``(h, w, 3)``, sRGB: counts on a logarithmic scale by the first two variables, with labelled axes.

        Parameters
        ----------
        function
            Its shapes are drawn over the counts, each in its colour, as strong as its weight. With one variable: a
            `TransferFunction`, whose extinction is drawn in its colours.

        Raises
        ------
        ValueRangeError
            When the function looks at other variables.
        """
        from .function import TransferFunction

        if (len(self.axes) == 1) != isinstance(function, TransferFunction) and function is not None:
            what = f"is a {type(function).__name__}, the histogram has {len(self.axes)} variables"
            raise ValueRangeError("function", what, "count the function's variables")
        if len(self.axes) == 1:
            from .function_picture import count_picture

            return count_picture(self, function)  # type: ignore[arg-type]
        from .histogram_picture import picture

        return picture(self, function)  # type: ignore[arg-type]

    def save(self, path: str | Path, function: JointFunction | TransferFunction | None = None) -> None:
        """Write the ``picture`` to a PNG file.

        Raises
        ------
        FileError
            For other endings, and where the file cannot be written.
        """
        from PIL import Image

        if Path(path).suffix.lower() != ".png":
            raise FileError(str(path), "is no PNG file", "end its name in .png")
        drawn = Image.fromarray(self.picture(function))
        try:
            drawn.save(path)
        except OSError as error:
            raise FileError(str(path), f"cannot be written ({error.strerror or error})") from error

    def _repr_png_(self) -> bytes:
        from .histogram_picture import png

        return png(self.picture())


def joint_histogram(
    volume: Volume,
    variables: Sequence[str | int | Axis] = ("value", "gradient"),
    bins: int | None = None,
    channel: int | str = 0,
    time: int = 0,
    progress: Progress | None = None,
    *,
    percentiles: tuple[float, float] = PERCENTILES,
) -> JointHistogram:
    """Count the samples of a volume by one, two or three variables; empty samples stay out.

    Memory is bounded: a few slices at a time are looked at. Derivatives are those of ``airlight.transfer.derivatives``.

    Parameters
    ----------
    volume, channel, time
        Whose samples; ``"value"``, ``"gradient"`` and ``"second"`` are those of ``channel``.
    variables
        One to three of ``"value"``, ``"gradient"``, ``"second"`` and channels by number or name (see `Axis`); an `Axis`
        instead chooses the stretch, too.
    bins
        Number of bins along each axis, 2 to 4096, or 512 for three variables; 256, or 64, when left out.
    progress
        Called with ``("histogram", done, total)``.
    percentiles
        Axes that are not given reach between these percentiles of the samples, so that outliers do not squeeze the rest:
        values and channels between both; whole values, scaled or not, get bins that hold as many of them each; gradients from 0
        to the higher one; second derivatives as far to both sides of 0 as both need. Of large volumes they are taken from about
        eight million samples, spread evenly.

    Raises
    ------
    ValueRangeError
        For other numbers of variables or bins, and percentiles that do not rise within [0, 100].
    DataError
        For channels and times that the volume does not have.
    """
    named = [v.variable if isinstance(v, Axis) else check_variable(v, f"variables[{i}]") for i, v in enumerate(variables)]
    if len(named) not in BINS:
        raise ValueRangeError("variables", f"are {named}", "give one, two or three")
    for number, variable in enumerate(named):
        if variable not in VARIABLES:
            channel_of(variable, volume, f"variables[{number}]")
    n = BINS[len(named)] if bins is None else bins
    if not 2 <= n <= MOST_BINS[len(named)]:
        raise ValueRangeError("bins", f"is {n}, must lie in [2, {MOST_BINS[len(named)]}] for {len(named)} variables")
    if not 0 <= percentiles[0] < percentiles[1] <= 100:
        raise ValueRangeError("percentiles", f"are {percentiles}, must rise within [0, 100]")
    source = Samples(volume, tuple(named), volume.channel_index(channel), time)
    axes = check_axes((v if isinstance(v, Axis) else source.axis(i, n, percentiles) for i, v in enumerate(variables)), least=1)
    counts = np.zeros(n ** len(axes), dtype=np.int64)
    total = within = 0
    for samples in source.batches(1, progress):
        cell, inside = np.zeros(samples.shape[1], dtype=np.int64), np.ones(samples.shape[1], dtype=bool)
        for axis, values in zip(axes[::-1], samples[::-1], strict=True):
            # The highest end belongs to the last bin.
            inside &= (values >= axis.low) & (values <= axis.high)
            place = (np.clip(values, axis.low, axis.high) - axis.low) * (n / axis.span)
            cell = cell * n + np.minimum(place.astype(np.int64), n - 1)
        cell = cell[inside]
        total, within = total + samples.shape[1], within + len(cell)
        if len(counts) <= 1 << 18:
            counts += np.bincount(cell, minlength=len(counts))
        else:
            np.add.at(counts, cell, 1)
    shape = (n,) * len(axes)
    voxels = int(np.prod(volume.size))
    units = tuple(_unit(volume, axis.variable) for axis in axes)
    return JointHistogram(counts.reshape(shape), axes, outside=total - within, empty=voxels - total, units=units)


def _unit(volume: Volume, variable: str | int) -> str:
    """Return the unit of a variable where the volume tells those that it is made of."""
    if variable in ("gradient", "second"):
        data, world = volume.value_unit, volume.units
        return f"{data}/{world}{'²' if variable == 'second' else ''}" if data and world else ""
    return volume.value_unit or ""


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of some variables of a volume, a few slices at a time.

    Attributes
    ----------
    volume, channel, time
        Where they are.
    variables
        As in `Axis`.
    """

    volume: Volume
    variables: tuple[str | int, ...]
    channel: int
    time: int

    def batches(self, every: int = 1, progress: Progress | None = None) -> Iterator[FloatArray]:
        """Samples (k, m), float64, that are not empty, of every so many pieces of the volume."""
        chosen = places(self.volume.grid(self.channel, self.time).shape)[every // 2 :: every]
        order = max((VARIABLES.index(v) for v in self.variables if isinstance(v, str) and v in VARIABLES), default=0)
        for done, place in enumerate(chosen, 1):
            own = piece(self.volume, place, self.channel, self.time, order)
            parts: list[FloatArray | None] = []
            full = own.full
            for variable in self.variables:
                named = {"value": own.value, "gradient": own.gradient, "second": own.second}
                if variable in VARIABLES:
                    parts.append(named[str(variable)])
                    continue
                other: Piece = piece(self.volume, place, variable, self.time, 0)
                parts.append(other.value)
                if other.full is not None:
                    full = other.full if full is None else full & other.full
            yield np.stack([p.ravel() if full is None else p[full] for p in parts if p is not None])
            if progress is not None:
                progress("histogram", done, len(chosen))

    def axis(self, number: int, bins: int, percentiles: tuple[float, float] = PERCENTILES) -> Axis:
        """Stretch of one of the variables that holds all but outliers; see ``joint_histogram``."""
        variable = self.variables[number]
        every = max(1, int(np.prod(self.volume.size)) // SAMPLES_FOR_AXES)
        alone = Samples(self.volume, (variable,), self.channel, self.time)
        found = np.concatenate([part[0] for part in alone.batches(every)])
        if found.size == 0:
            return Axis(variable, 0.0, 1.0)
        # Samples, not numbers between them: what many samples have in common stays in.
        low = float(np.percentile(found, percentiles[0], method="lower"))
        high = float(np.percentile(found, percentiles[1], method="higher"))
        if variable == "gradient":
            return _axis(variable, 0.0, high)
        if variable == "second":
            reach = max(abs(low), abs(high))
            return _axis(variable, -reach, reach)
        quantum = 1.0 if self.volume.dtype.kind in "iub" else _quantum(found)
        if quantum == 0:
            return _axis(variable, low, high)
        width = round((high - low) / quantum) + 1
        per_bin = np.ceil(width / bins) if 2 * width > bins else width / bins
        begin = low - 0.5 * quantum
        return Axis(variable, begin, float(begin + per_bin * bins * quantum))


def _quantum(samples: FloatArray) -> float:
    """Distance between neighbouring values where all are multiples of it, as whole numbers that were scaled are; else 0."""
    values = np.unique(samples[:: max(1, len(samples) // SAMPLES_FOR_QUANTUM)])
    if not LEAST_MULTIPLES <= len(values) <= MOST_MULTIPLES:
        return 0.0
    least = float(np.diff(values).min())
    multiples = (values - values[0]) / least
    return least if (np.abs(multiples - np.rint(multiples)) < 0.01).all() else 0.0


def _axis(variable: str | int, low: float, high: float) -> Axis:
    """Axis from low to high, widened where these are equal."""
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        width = max(abs(high), abs(low)) or 1.0
        high = high + width
    return Axis(variable, low, high)
