"""Labels on the command line: a volume of labels beside the image, names, and which of them are shown."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any

from cyclopts import Group, Parameter

from ..errors import ValueRangeError
from ..labels import Labels
from ..labels.names import read_label_table
from ..labels.ranges import ONE_OR_RANGE, text_to_ids
from ..scene import Layer
from ..volume import Volume
from .inputs import open_named
from .progress import ProgressBar

LABELS = Group("Labels", sort_key=1)
FEW_LABELS = 100
"""So many are never taken for the values of an image."""


def _of_labels(what: str) -> Parameter:
    return Parameter(
        group=LABELS, metavar="LABELS", allow_leading_hyphen=True, help=f'{what}; numbers, ranges or names, e.g. "3,5-9,liver".'
    )


@Parameter(name="*")
@dataclass(frozen=True)
class LabelOptions:
    """Regions of the image, from a volume of whole numbers on the same or another grid."""

    labels: Annotated[
        str | None,
        Parameter(group=LABELS, metavar="FILE", help="Volume of labels beside the image: each region gets a tint of its own."),
    ] = None
    label_names: Annotated[
        str | None,
        Parameter(
            group=LABELS,
            metavar="FILE",
            help='Names and colours of labels: a text file with lines "label name" or "label name red green blue".',
        ),
    ] = None
    hide_labels: Annotated[str | None, _of_labels("Regions that are left out; the background is 0")] = None
    only_labels: Annotated[str | None, _of_labels("Regions that alone are drawn, without the background")] = None
    highlight_labels: Annotated[str | None, _of_labels("Regions that stand out: all others fade")] = None


def with_labels(
    layer: Layer, options: LabelOptions, progress: ProgressBar | None = None, max_memory: int | None = None
) -> Layer:
    """Return a layer with the labels that are asked for, or those of its scene file, shown as is asked for.

    Raises
    ------
    ValueRangeError
        When labels are chosen and there are none, or a name is unknown.
    FileError
        When a file cannot be read.
    """
    if options == LabelOptions():
        return layer
    labels = layer.labels
    if options.labels is not None:
        labels = Labels(_opened(options.labels, layer.volume, progress, max_memory))
    if labels is None:
        name = next(name for name, value in vars(options).items() if value is not None)
        raise ValueRangeError(
            f"--{name.replace('_', '-')}", "is given, but there are no labels", "name their file: --labels FILE"
        )
    if options.label_names is not None:
        labels = read_label_table(options.label_names).applied_to(labels)
    if options.hide_labels is not None:
        labels = labels.hide(parse_labels(options.hide_labels, labels, "--hide-labels"))
    if options.only_labels is not None:
        labels = labels.only(parse_labels(options.only_labels, labels, "--only-labels"), labels.time_of(layer.time))
    if options.highlight_labels is not None:
        labels = labels.highlight(parse_labels(options.highlight_labels, labels, "--highlight-labels"))
    return replace(layer, labels=labels)


def parse_labels(text: str, labels: Labels, where: str = "labels") -> frozenset[int]:
    """Labels of a text with numbers, ranges and names, with commas between them; ``where`` names the option in errors."""
    return frozenset().union(*(found for _, found in _parts(text, labels, where)))


def _parts(text: str, labels: Labels, where: str) -> Iterator[tuple[str, frozenset[int]]]:
    """Each number, range or name of a text, with its labels."""
    names = {name for _, name in labels.names}
    for part in filter(None, (word.strip() for word in text.split(","))):
        is_number = ONE_OR_RANGE.fullmatch(part) and (part not in names or part.removeprefix("-").isdecimal())
        try:
            yield part, text_to_ids(part) if is_number else labels.numbers(part)
        except ValueRangeError as error:
            nameless = "give numbers and ranges, such as 3,5-9, or names by --label-names FILE"
            raise ValueRangeError(where, error.what, error.remedy if is_number or names else nameless) from None


def label_notes(layer: Layer, options: LabelOptions) -> Iterator[str]:
    """Tell of labels that were asked for and do not occur, and of labels that look like an image."""
    labels = layer.labels
    if labels is None:
        return
    time = labels.time_of(layer.time)
    ids = labels.ids(time)
    occurring = frozenset(ids.tolist())
    if options.labels is not None and _seem_values(labels, time):
        yield (
            f"{options.labels} was taken as labels, and looks like an image: {len(ids):,} different values from "
            f"{ids.min():,} to {ids.max():,}, seldom the same in neighbouring voxels"
        )
    for name in ("hide_labels", "only_labels", "highlight_labels"):
        text, option = getattr(options, name), f"--{name.replace('_', '-')}"
        for part, found in _parts(text or "", labels, option):
            if not found & occurring:
                yield f"{option} {part}: no voxel has this label; they run from {ids.min():,} to {ids.max():,}"


def _seem_values(labels: Labels, time: int) -> bool:
    """Whether most voxels outside of the background differ from their neighbours along x."""
    grid = labels.volume.grid(0, time)
    pairs = same = 0
    for part in grid:
        inside = part[:, 1:] != labels.background
        pairs += int(inside.sum())
        same += int((inside & (part[:, 1:] == part[:, :-1])).sum())
    return len(labels.ids(time)) > FEW_LABELS and same < pairs / 2


def _opened(path: str, image: Volume, progress: ProgressBar | None, max_memory: int | None) -> Volume:
    """Volume of labels; the image itself where it is the same file, as a whole, so that it is read once."""
    source = image.source
    is_whole = source is not None and not (source.dataset or source.level or source.options)
    if source is not None and is_whole and os.path.realpath(source.path) == os.path.realpath(path):
        return image
    limits: dict[str, Any] = {} if max_memory is None else {"max_memory": max_memory}
    return open_named(path, progress, **limits)
