"""Labels beside an image, as a frozen value: which volume, and how each of its regions is drawn."""

from __future__ import annotations

import copy
import difflib
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Integral
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError, ValueRangeError
from ..transfer import TransferFunction
from ..transfer.colour import Colour
from ..transfer.given import listed, set_fields, share
from ..transfer.kinds import AnyFunction, DrawnFunction
from ..transfer.regions import ByRegion
from ..volume import Volume
from .dense import check_labels, label_numbers
from .ranges import ids_to_text, text_to_ids
from .style import LabelStyle, luminance, vivid

Some = int | str | Iterable[int | str]

PLAIN = LabelStyle((1.0, 1.0, 1.0))


@dataclass(frozen=True, init=False)
class Labels:
    """Regions of an image: a volume of labels, on any grid, and a style for each label.

    Values: methods return changed ones, and what lies on the device is not uploaded again, but for a table of styles.

    Parameters
    ----------
    volume
        A ``Volume`` of integers, up to 64 bits, or anything that makes one; its own ``world_from_index`` places it. What lies
        outside of its voxels is background.
    styles
        Style for each of some labels: a ``LabelStyle``, a colour or a transfer function.
    default
        Style of the other labels.
    background
        The label of what is no region; drawn as the image is unless ``styles`` has it.
    hidden
        Labels that are not drawn.
    highlighted
        Labels that stand out in the pure, bright colours of their hues (greys in white, which keeps the image's colours): while
        there are any, all others are grey, and their opacities multiplied by ``fade``.
    fade
        See ``highlighted``; in [0, 1]. What the presets draw as solid becomes a veil.
    names
        Names of labels, by which they may be called.

    Raises
    ------
    DataError
        When the volume does not hold integers, or has several channels.
    ValueRangeError
        For labels that are no whole numbers, and a fade outside of [0, 1].

    Examples
    --------
    >>> import airlight as al, numpy as np
    >>> regions = np.zeros((4, 4, 4), dtype=np.uint8)
    >>> regions[1:3] = 7
    >>> labels = al.Labels(regions, {7: "red"}, names={7: "liver"})
    >>> labels.hide("liver").hidden
    frozenset({7})
    """

    volume: Volume
    styles: tuple[tuple[int, LabelStyle], ...]
    default: LabelStyle
    background: int
    hidden: frozenset[int]
    highlighted: frozenset[int]
    fade: float
    names: tuple[tuple[int, str], ...] = field(repr=False)

    def __init__(
        self,
        volume: Any,
        styles: Mapping[int, LabelStyle | TransferFunction | Colour] | None = None,
        default: LabelStyle | TransferFunction | Colour | None = None,
        *,
        background: int = 0,
        hidden: Iterable[int] = (),
        highlighted: Iterable[int] = (),
        fade: float = 0.0005,
        names: Mapping[int, str] | None = None,
    ) -> None:
        if isinstance(volume, (str, os.PathLike)):
            raise DataError("labels", f"got the path {str(volume)!r}", "pass airlight.open(path)")
        volume = volume if isinstance(volume, Volume) else Volume(volume)
        check_labels(volume)
        given = {_whole(label): _style(style) for label, style in _mapping(styles, "styles").items()}
        object.__setattr__(self, "volume", volume)
        object.__setattr__(self, "styles", tuple(sorted(given.items(), key=lambda item: item[0])))
        object.__setattr__(self, "default", LabelStyle() if default is None else _style(default))
        object.__setattr__(self, "background", _whole(background))
        object.__setattr__(self, "hidden", _wholes(hidden, "labels.hidden"))
        object.__setattr__(self, "highlighted", _wholes(highlighted, "labels.highlighted"))
        object.__setattr__(self, "fade", share(fade, "labels.fade"))
        named = ((_whole(label), str(name)) for label, name in _mapping(names, "names").items())
        object.__setattr__(self, "names", tuple(sorted(named)))

    # -- what is there

    def ids(self, time: int = 0) -> npt.NDArray[Any]:
        """Labels that occur in the volume, the background first, then increasing."""
        return label_numbers(self.volume, time, self.background).ids

    def time_of(self, time: int) -> int:
        """Number of the labels' time step that belongs to one of the image: labels of one step belong to all."""
        return time if self.volume.time_count > 1 else 0

    def name_of(self, label: int) -> str:
        """Name of a label; its number where it has none."""
        return self.name_by_label.get(label, str(label))

    def style_of(self, label: int) -> LabelStyle:
        """Style of a label, whether it is shown or not."""
        return self.by_label.get(label, PLAIN if label == self.background else self.default)

    def opacity_of(self, label: int) -> float:
        """Opacity with which a label is drawn now: 0 where it is hidden, less where others are highlighted."""
        if label in self.hidden:
            return 0.0
        return self.style_of(label).opacity * (self.fade if self._is_faded(label) else 1.0)

    def tint_of(self, label: int) -> tuple[float, float, float]:
        """Linear factor of the colours in which a label is drawn now: vivid where it is highlighted, grey where others are."""
        tint = self.style_of(label).tint(label)
        if label in self.highlighted:
            r, g, b = vivid(np.array(tint)).tolist()
            return r, g, b
        if not self._is_faded(label):
            return tint
        grey = luminance(tint)
        return grey, grey, grey

    def _is_faded(self, label: int) -> bool:
        return bool(self.highlighted) and label not in self.highlighted

    @cached_property
    def functions(self) -> tuple[TransferFunction, ...]:
        """Transfer functions that regions have of their own, in the order of their labels, each once."""
        own = [style.transfer for _, style in self.styles] + [self.default.transfer]
        return tuple(dict.fromkeys(function for function in own if function is not None))

    def beside(self, function: AnyFunction, density: float = 1.0) -> DrawnFunction:
        """Return a layer's function together with those that regions have of their own, multiplied by a density.

        Raises
        ------
        ValueRangeError
            When regions have functions of their own and the layer's is of several variables or channels.
        """
        if not self.functions:
            return function
        if not isinstance(function, TransferFunction):
            what = f"have transfer functions, and the layer's is a {type(function).__name__}"
            raise ValueRangeError("labels.styles", what, "they go with a TransferFunction")
        return ByRegion((function, *(own.scaled(density) for own in self.functions)))

    # -- changed values

    def hide(self, labels: Some) -> Labels:
        """Return the labels with some of them hidden, beside those that are hidden already; given by number or name."""
        return replace_labels(self, hidden=self.hidden | self.numbers(labels))

    def show(self, labels: Some | None = None) -> Labels:
        """Return the labels with some of them, or all, shown again."""
        return replace_labels(self, hidden=frozenset() if labels is None else self.hidden - self.numbers(labels))

    def only(self, labels: Some, time: int = 0) -> Labels:
        """Return the labels with all hidden but some of those that occur; the background is hidden too unless it is named."""
        return replace_labels(self, hidden=frozenset(self.ids(time).tolist()) - self.numbers(labels))

    def highlight(self, labels: Some, fade: float | None = None) -> Labels:
        """Return the labels with these, and no others, standing out; none of them ends it."""
        return replace_labels(self, highlighted=self.numbers(labels), fade=self.fade if fade is None else fade)

    def with_style(
        self,
        labels: Some,
        style: LabelStyle | TransferFunction | Colour | None = None,
        *,
        colour: Colour | None = None,
        opacity: float | None = None,
        transfer: TransferFunction | None = None,
    ) -> Labels:
        """Return the labels with another style for some of them; what is not given of it stays as it was."""
        styles = dict(self.styles)
        for label in self.numbers(labels):
            old = self.style_of(label) if style is None else _style(style)
            styles[label] = LabelStyle(
                old.colour if colour is None else colour,
                old.opacity if opacity is None else opacity,
                old.transfer if transfer is None else transfer,
            )
        return replace_labels(self, styles=styles)

    def with_names(self, names: Mapping[int, str]) -> Labels:
        """Return the labels with these names beside those that they have."""
        return replace_labels(self, names=dict(self.names) | dict(names))

    def with_names_of(self, other: Labels) -> Labels:
        """Return the labels with another's names in place of their own: the very same, since there may be very many."""
        made = copy.copy(self)
        set_fields(made, names=other.names)
        made.__dict__.pop("_plain", None)
        for name in {"name_by_label", "_by_name", "_plain_names"}:
            made.__dict__.pop(name, None)
            if name in other.__dict__:
                made.__dict__[name] = other.__dict__[name]
        return made

    def numbers(self, labels: Some) -> frozenset[int]:
        """Numbers of labels that are given by number or name; a name stands for all labels that have it.

        Raises
        ------
        ValueRangeError
            For names that no label has, and for what is neither.
        """
        some = [labels] if isinstance(labels, (str, int, Integral)) else listed(labels, "labels", "give numbers or names")
        return frozenset().union(*map(self._numbers, some))

    def _numbers(self, label: int | str) -> frozenset[int]:
        if not isinstance(label, str):
            return frozenset({_whole(label)})
        if label not in self._by_name:
            near = difflib.get_close_matches(label, self._by_name, n=3)
            remedy = "see names" if self.names else "they have no names: give numbers"
            raise ValueRangeError("labels", f"have no {label!r}", f"is it {' or '.join(map(repr, near))}?" if near else remedy)
        return self._by_name[label]

    # -- for scene files

    def to_dict(self) -> dict[str, Any]:
        """Plain data without the volume, as scene files keep it; nothing of what is as it comes."""
        return dict(self._plain)

    @cached_property
    def _plain(self) -> dict[str, Any]:
        plain = Labels(self.volume)
        data: dict[str, Any] = {"styles": {str(label): style.to_dict() for label, style in self.styles}} if self.styles else {}
        data |= {} if self.default == plain.default else {"default": self.default.to_dict()}
        data |= {name: getattr(self, name) for name in ("background", "fade") if getattr(self, name) != getattr(plain, name)}
        data |= {name: ids_to_text(ids) for name in ("hidden", "highlighted") if (ids := getattr(self, name))}
        return data | ({"names": self._plain_names} if self.names else {})

    @cached_property
    def _plain_names(self) -> dict[str, str]:
        return {str(label): name for label, name in self.names}

    @classmethod
    def from_dict(cls, volume: Volume, data: Mapping[str, Any]) -> Labels:
        """Return the labels that ``to_dict`` wrote."""
        known = {"styles", "default", "background", "fade", "hidden", "highlighted", "names"}
        if unknown := sorted(set(data) - known):
            raise ValueRangeError("labels", f"has unknown entries {unknown}", f"use {', '.join(sorted(known))}")
        given = dict(data)
        for name in ("hidden", "highlighted"):
            if isinstance(given.get(name), str):
                given[name] = text_to_ids(given[name], f"labels.{name}")
        for name, read in (("styles", LabelStyle.from_dict), ("names", str)):
            if name in given:
                _mapping(given[name], name)
                given[name] = {_whole_text(label): read(value) for label, value in given[name].items()}
        if "default" in given:
            given["default"] = LabelStyle.from_dict(given["default"])
        return cls(volume, **given)

    # -- look-up

    @cached_property
    def by_label(self) -> dict[int, LabelStyle]:
        """Style of each label that has one of its own."""
        return dict(self.styles)

    @cached_property
    def name_by_label(self) -> dict[int, str]:
        """Name of each label that has one."""
        return dict(self.names)

    @cached_property
    def _by_name(self) -> dict[str, frozenset[int]]:
        found: dict[str, set[int]] = {}
        for label, name in self.names:
            found.setdefault(name, set()).add(label)
        return {name: frozenset(labels) for name, labels in found.items()}


def replace_labels(labels: Labels, **changes: Any) -> Labels:
    """Labels with some of their fields changed."""
    fields = ("default", "background", "hidden", "highlighted", "fade")
    given = {name: getattr(labels, name) for name in fields} | {"styles": labels.by_label, "names": dict(labels.names)}
    return Labels(labels.volume, **(given | changes))


def _mapping(given: Any, name: str) -> Mapping[Any, Any]:
    if given is not None and not isinstance(given, Mapping):
        raise ValueRangeError(f"labels.{name}", f"are {given!r}, must be a table", f"give {name} by label")
    return given or {}


def _style(given: LabelStyle | TransferFunction | Colour) -> LabelStyle:
    if isinstance(given, LabelStyle):
        return given
    return LabelStyle(transfer=given) if isinstance(given, TransferFunction) else LabelStyle(given)


def _whole(label: Any) -> int:
    if type(label) is int:  # told at once, since there may be hundreds of thousands
        return label
    if isinstance(label, Integral) and not isinstance(label, bool):
        return int(label)
    if isinstance(label, float) and label.is_integer():
        return int(label)
    raise ValueRangeError("labels", f"got {label!r} for a label, must be a whole number")


def _wholes(labels: Any, where: str) -> frozenset[int]:
    return frozenset(map(_whole, listed(labels, where, "give the labels")))


def _whole_text(label: str) -> int:
    try:
        return int(label)
    except ValueError:
        raise ValueRangeError("labels", f"got {label!r} for a label, must be a whole number") from None
