"""Styles of all labels that occur, as the table that the device reads."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .dense import label_numbers
from .style import LabelStyle, distinct_colours, vivid
from .value import Labels

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear light, Rec. 709
ROW_WIDTH = 1024  # styles to a line of the table, and lines to a slice


def styles_table(labels: Labels, time: int = 0) -> npt.NDArray[np.float32]:
    """Styles of the labels that occur, (depth, height, 1024, 4), in the order of their numbers, line by line.

    Linear colour times opacity, and opacity; plus two for each number of the region's own function in ``functions``, from 1
    on. Made once for a value.
    """
    cache: dict[int, npt.NDArray[np.float32]] = labels.__dict__.setdefault("_styles_tables", {})
    if time not in cache:
        rows = _rows(labels, time)
        lines = -(-len(rows) // ROW_WIDTH)
        table = np.zeros((-(-lines // ROW_WIDTH), min(lines, ROW_WIDTH), ROW_WIDTH, 4), dtype=np.float32)
        table.reshape(-1, 4)[: len(rows)] = rows
        table.flags.writeable = False
        cache[time] = table
    return cache[time]


def drawn_labels(labels: Labels, time: int = 0) -> bytes:
    """Whether each of the labels that occur is drawn, 1 or 0, in rising order of the labels. Made once for a value."""
    cache: dict[int, bytes] = labels.__dict__.setdefault("_drawn_labels", {})
    if time not in cache:
        ids = label_numbers(labels.volume, time, labels.background).ids
        opacities = styles_table(labels, time).reshape(-1, 4)[: len(ids), 3] % 2
        cache[time] = (opacities[np.argsort(ids)] > 0).tobytes()
    return cache[time]


def _rows(labels: Labels, time: int) -> npt.NDArray[np.float64]:
    numbers = label_numbers(labels.volume, time, labels.background)
    rows = np.empty((len(numbers.ids), 4))
    function = np.zeros(len(rows))

    def put(number: int | slice, style: LabelStyle, label: int) -> None:
        rows[number] = *style.tint(label), style.opacity
        function[number] = 0 if style.transfer is None else 1 + labels.functions.index(style.transfer)

    put(slice(None), labels.default, 0)
    if labels.default.colour is None and labels.default.transfer is None:
        rows[:, :3] = distinct_colours(numbers.ids)
    own = {labels.background: labels.style_of(labels.background)} | labels.by_label
    for (label, style), number in zip(own.items(), numbers.of(own), strict=True):
        if number >= 0:
            put(int(number), style, label)
    if labels.highlighted:
        bright = _there(numbers.of(labels.highlighted))
        rows[bright, :3] = vivid(rows[bright, :3])
        faded = np.ones(len(rows), dtype=bool)
        faded[bright] = False
        rows[faded, 3] *= labels.fade
        rows[faded, :3] = (rows[faded, :3] @ LUMINANCE)[:, None]
    rows[_there(numbers.of(labels.hidden)), 3] = 0.0
    rows[:, :3] *= rows[:, 3:]
    rows[:, 3] += 2 * function
    return rows


def _there(numbers: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return numbers[numbers >= 0]
