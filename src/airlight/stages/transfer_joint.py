"""Transfer functions of two and three variables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, ClassVar

import numpy as np

from ..errors import StageError
from ..stage import U32, Conditions, Context, Estimate, Resource, Stretches, Table, Vec3f, Vec3u, Vec4f, param
from ..transfer.channels import MOST_CHANNELS
from ..transfer.joint import TABLE_ENTRIES, JointFunction, just
from ..transfer.kinds import DrawnFunction
from .transfer import Transfer, ends_of, widest

GRADIENT, SECOND = MOST_CHANNELS, MOST_CHANNELS + 1
SAMPLES = 32
MOST_LOOKED_AT = {2: 256, 3: 64}
"""Cells along each axis, by number of variables, at which the error of tables is looked at."""


@dataclass(frozen=True)
class JointUniforms:
    """Axes of the function: what each variable is (number of a channel of the field, or one of the above), and its range."""

    variables: Vec3u = param((0, 0, 0))
    samples: U32 = param(0)
    low: Vec3f = param((0.0, 0.0, 0.0), unit="variable")
    per_variable: Vec3f = param((0.0, 0.0, 0.0), unit="1/variable")
    entries: Vec3f = param((1.0, 1.0, 1.0))
    empty_low: Vec4f = param((3e38, 3e38, 3e38, 3e38), unit="data")
    empty_high: Vec4f = param((-3e38, -3e38, -3e38, -3e38), unit="data")


@dataclass(frozen=True)
class Joint(Transfer):
    """A function of two or three variables, from a table of its shapes.

    It stands in for ``postclassified`` with no samples inside a slab, and for ``preintegrated`` (whose ``entries`` it takes
    over) and ``preintegrated_fast`` with up to 32: the variables run straight between the ends of a slab, which is cut into as
    many pieces as the way is long in entries of the table.
    """

    name: ClassVar[str] = "joint"
    wgsl: ClassVar[str] = "transfer/joint.wgsl"
    uniform_type: ClassVar[type] = JointUniforms
    samples: U32 = param(SAMPLES, at_least=0, up_to=1024, help="most pieces that a slab is cut into; 0: the mean of its ends")
    entries: U32 = param(0, at_least=0, up_to=4096, help="size of the table along each axis; 0: 256, or 64 of three variables")

    @property
    def integrates(self) -> bool:  # type: ignore[override]
        """Whether slabs are cut into pieces along the straight line between their ends."""
        return self.samples > 0

    def uses_gradient(self, function: DrawnFunction) -> bool:
        """Whether one of the variables is made of the gradient."""
        return isinstance(function, JointFunction) and not {"gradient", "second"}.isdisjoint(function.variables)

    def for_function(self, function: DrawnFunction) -> Transfer:
        """Return the stage for a function of several variables."""
        if not isinstance(function, JointFunction):
            raise StageError("look.transfer 'joint'", f"cannot draw a {type(function).__name__}", "use preintegrated")
        return self

    def variant(self, context: Context) -> dict[str, bool]:
        """Return what colours mean, which variables have to be computed, and whether slabs are cut into pieces."""
        function: JointFunction = context.transfer
        has_second = "second" in function.variables
        return {
            "associated": function.associated,
            "has_gradient": self.uses_gradient(function),
            "has_second": has_second,
            "cuts_slabs": self.samples > 0,
        }

    def empty_values(self, context: Context) -> Stretches:
        """Return the stretches of the first variable on which nothing is, where that is a value."""
        function: JointFunction = context.transfer
        if function.variables[0] in ("gradient", "second"):
            return ()
        return widest(function.empty_values_widened(function.axes[0].span / (self._entries(function) - 1)))

    def empty_where(self, context: Context) -> Conditions | None:
        """Return that each shape is missed by one of its variables at least; nothing is looked up of the second derivative."""
        function: JointFunction = context.transfer
        numbers = [_number(variable, context) for variable in function.variables]
        names = [{GRADIENT: "gradient", SECOND: "second"}.get(number, number) for number in numbers]
        last = self._entries(function) - 1
        return tuple(
            tuple(
                stretch
                for name, (low, high) in zip(names, bounds, strict=True)
                for stretch in ((name, -math.inf, just(low, -math.inf)), (name, just(high, math.inf), math.inf))
            )
            for bounds in function.bounds_widened([axis.span / last for axis in function.axes])
        )

    def uniforms(self, context: Context) -> Any:
        """Return the axes of the function and the size of its table."""
        function: JointFunction = context.transfer
        n, count = self._entries(function), len(function.axes)
        low, high = ends_of(self.empty_values(context))
        pad = [0.0] * (3 - count)
        return JointUniforms(
            variables=tuple([_number(variable, context) for variable in function.variables] + [0] * (3 - count)),  # type: ignore[arg-type]
            samples=self.samples,
            low=tuple([axis.low for axis in function.axes] + pad),  # type: ignore[arg-type]
            per_variable=tuple([1 / axis.span for axis in function.axes] + pad),  # type: ignore[arg-type]
            entries=tuple([float(n)] * count + [1.0] * (3 - count)),  # type: ignore[arg-type]
            empty_low=low,
            empty_high=high,
        )

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the table of the shapes."""
        return {"shapes": Table(context.transfer.table(self._entries(context.transfer)))}

    def errors(self, context: Context) -> Mapping[str, Estimate]:
        """Return what interpolation between the entries of the table may cost, as a share of the greatest extinction."""
        return {"extinction between entries": partial(interpolation_error, context.transfer, self._entries(context.transfer))}

    def _entries(self, function: JointFunction) -> int:
        return self.entries or TABLE_ENTRIES[len(function.axes)]


@lru_cache(maxsize=16)
def interpolation_error(function: JointFunction, entries: int) -> float:
    """Greatest difference of table and function in the middles of the table's cells, as a share of the greatest extinction."""
    extinction = function.table(entries)[..., 3].astype(np.float64)
    count = len(function.axes)
    extinction = extinction.reshape((entries,) * count)
    every = max(1, entries // MOST_LOOKED_AT[count])
    first = np.arange(0, entries - 1, every)
    middle = np.zeros((len(first),) * count)
    for corner in np.ndindex(*(2,) * count):
        middle += extinction[tuple(slice(c, entries - 1 + c, every) for c in corner)] / 2**count
    places = np.meshgrid(*[(first + 0.5) / (entries - 1)] * count, indexing="ij")
    # The first variable runs along the last axis of the table.
    coordinates = np.stack([a.low + p * a.span for a, p in zip(function.axes, reversed(places), strict=True)], axis=-1)
    greatest = extinction.max()
    return float(np.abs(middle - function(coordinates)[1]).max() / greatest) if greatest > 0 else 0.0


def _number(variable: str | int, context: Context) -> int:
    """Return the place of a channel among those that the field holds, or the number of what is made of the gradient."""
    if variable == "gradient":
        return GRADIENT
    if variable == "second":
        return SECOND
    return 0 if variable == "value" else context.channels.index(context.volume.channel_index(variable))


def stand_in(stage: Transfer, function: JointFunction) -> Transfer:
    """Return the stage that draws such a function in the way of another."""
    if stage.name not in ("postclassified", "preintegrated", "preintegrated_fast", "joint"):
        raise StageError(f"look.transfer {stage.name!r}", "draws functions of one value", "use preintegrated or postclassified")
    return Joint(0 if stage.name == "postclassified" else SAMPLES, getattr(stage, "entries", 0))
