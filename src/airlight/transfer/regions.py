"""A transfer function for each of some regions of a volume, and one for all the rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ..errors import ValueRangeError
from .function import TransferFunction

MOST_FUNCTIONS = 16


@dataclass(frozen=True)
class ByRegion:
    """The layer's function, which comes first, and those that regions of its labels have of their own.

    Raises
    ------
    ValueRangeError
        When there are more than 16, associated and other functions are mixed, or one has surfaces.
    """

    functions: tuple[TransferFunction, ...]

    def __post_init__(self) -> None:
        """Check that the functions go together."""
        if len(self.functions) > MOST_FUNCTIONS:
            allowed = f"must be at most {MOST_FUNCTIONS - 1} beside the layer's"
            raise ValueRangeError("labels.styles", f"have {len(self.functions) - 1} transfer functions, {allowed}")
        if len({function.associated for function in self.functions}) > 1:
            raise ValueRangeError("labels.styles", "mix associated and other transfer functions", "make all of one kind")
        if any(function.surfaces for function in self.functions):
            raise ValueRangeError("labels.styles", "have transfer functions, and one has surfaces", "leave these out")

    @cached_property
    def empty_stretches(self) -> tuple[tuple[float, float], ...]:
        """Closed intervals of values on which none of the functions holds anything."""
        common = self.functions[0].empty_stretches
        for function in self.functions[1:]:
            pairs = [(max(a, c), min(b, d)) for a, b in common for c, d in function.empty_stretches]
            common = tuple((low, high) for low, high in pairs if low <= high)
        return common

    def scaled(self, density: float) -> ByRegion:
        """Return the functions with their extinctions multiplied."""
        return ByRegion(tuple(function.scaled(density) for function in self.functions))
