"""``airlight histogram``: a picture of where the samples of a volume lie by one, two or three variables."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import FileError, ValueRangeError
from ..transfer import TransferFunction
from ..transfer.histogram import joint_histogram
from ..transfer.joint import JointFunction
from ..transfer.joint_axes import VARIABLES, Axis, channel_of
from ..volume import Volume
from .build import open_input
from .inputs import INPUT
from .options import ReadOptions
from .parse import parse_transfer
from .progress import ProgressBar

UNLESS_TOLD = "value,gradient"


def histogram(
    input: Annotated[str, Parameter(help=INPUT)],
    /,
    *,
    output: Annotated[str, Parameter(name=["--output", "-o"], metavar="FILE.png", help="Where the picture is written.")],
    variables: Annotated[
        str | None,
        Parameter(
            metavar="A,B",
            help="One to three of value, gradient, second (the second derivative along the gradient), and channels by number "
            f"or name; {UNLESS_TOLD} unless told. One is drawn as bars, a third one is summed over.",
        ),
    ] = None,
    bins: Annotated[int | None, Parameter(help="Bins along each axis; 256 unless told, 64 for three variables.")] = None,
    tf: Annotated[
        str | None,
        Parameter(
            metavar="FUNCTION",
            allow_leading_hyphen=True,
            help="Transfer function, as airlight render takes it, whose axes are taken and which is drawn on top.",
        ),
    ] = None,
    channel: Annotated[str, Parameter(help="Channel of value, gradient and second, by number (from 0) or name.")] = "0",
    time: Annotated[int, Parameter(help="Time step, from 0.")] = 0,
    read: ReadOptions | None = None,
) -> None:
    """Draw a joint histogram: how many samples have which value and gradient, on a logarithmic scale, with labelled axes.

    Materials are spots at the bottom, where gradients are small; boundaries between them are arches. For instance:

        airlight histogram tooth.nrrd -o histogram.png
        airlight histogram tooth.nrrd -o histogram.png --tf tooth.toml
        airlight histogram ct.nrrd -o second.png --variables value,second
        airlight histogram brain.nii.gz -o channels.png --variables 0,1
        airlight histogram ct.nrrd -o values.png --variables value
    """
    target = Path(output)
    if target.suffix.lower() != ".png":
        raise FileError(output, "is no PNG file", "end its name in .png")
    if not target.absolute().parent.is_dir():
        raise FileError(output, "cannot be written, its folder is not there", f"make {target.parent}")
    function = None if tf is None else _counted(tf)
    if function is not None and variables is not None:
        raise ValueRangeError("--variables", "and --tf exclude each other", "the function tells the variables")
    with ProgressBar() as progress:
        volume = open_input(input, read or ReadOptions(), progress)
        chosen = _variables(variables or UNLESS_TOLD, volume) if function is None else _axes(function)
        number = int(channel) if channel.isdecimal() else channel
        found = joint_histogram(volume, chosen, bins, number, time, progress)
    found.save(target, function)
    shown = int(found.counts.sum())
    print(f"{shown:,} samples; {found.outside:,} lie beyond the axes, {found.empty:,} are empty")
    for axis in found.axes:
        print(f"  {axis.variable!s:<10} {axis.low:.6g} to {axis.high:.6g}")


def _counted(text: str) -> TransferFunction | JointFunction:
    function = parse_transfer(text)
    if not isinstance(function, TransferFunction | JointFunction):
        raise ValueRangeError("--tf", f"is a {type(function).__name__}", "give a function of values, or of several variables")
    return function


def _axes(function: TransferFunction | JointFunction) -> Sequence[str | int | Axis]:
    return function.axes if isinstance(function, JointFunction) else ("value",)


def _variables(text: str, volume: Volume) -> list[str | int | Axis]:
    """Words between commas; whole numbers are channels."""
    names = [word.strip() for word in text.split(",")]
    if not all(names):
        raise ValueRangeError("--variables", f"is {text!r}, must be words with commas between", "e.g. value,gradient")
    found: list[str | int | Axis] = [
        int(name) if name.isdecimal() and name not in volume.channel_names else name for name in names
    ]
    for variable in found:
        if not isinstance(variable, Axis) and variable not in VARIABLES:
            channel_of(variable, volume, "--variables")
    return found
