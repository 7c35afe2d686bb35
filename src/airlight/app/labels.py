"""Labels on the command line: a volume of labels beside the image, names, and which of them are shown."""

from dataclasses import dataclass, replace
from typing import Annotated

from cyclopts import Group, Parameter

from ..errors import ValueRangeError
from ..labels import Labels
from ..labels.names import read_label_table
from ..labels.ranges import text_to_ids
from ..scene import Layer
from .progress import ProgressBar

LABELS = Group("Labels", sort_key=1)


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


def with_labels(layer: Layer, options: LabelOptions, progress: ProgressBar | None = None) -> Layer:
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
        from .. import io

        labels = Labels(io.open(options.labels, progress=progress))
    if labels is None:
        name = next(name for name, value in vars(options).items() if value is not None)
        raise ValueRangeError(
            f"--{name.replace('_', '-')}", "is given, but there are no labels", "name their file: --labels FILE"
        )
    if options.label_names is not None:
        labels = read_label_table(options.label_names).applied_to(labels)
    if options.hide_labels is not None:
        labels = labels.hide(parse_labels(options.hide_labels, labels))
    if options.only_labels is not None:
        labels = labels.only(parse_labels(options.only_labels, labels), labels.time_of(layer.time))
    if options.highlight_labels is not None:
        labels = labels.highlight(parse_labels(options.highlight_labels, labels))
    return replace(layer, labels=labels)


def parse_labels(text: str, labels: Labels) -> frozenset[int]:
    """Labels of a text with numbers, ranges and names, with commas between them."""
    found: frozenset[int] = frozenset()
    for part in filter(None, (word.strip() for word in text.split(","))):
        is_number = part.lstrip("-")[:1].isdigit()
        found |= text_to_ids(part) if is_number else labels.numbers(part)
    return found
