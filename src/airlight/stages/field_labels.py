"""The field of a layer that is nothing but labels: how much of a place is taken by regions that are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from ..errors import StageError
from ..labels import Labels
from ..stage import Context, Resource, Stage
from ..volume import Volume
from .field import Field


@dataclass(frozen=True)
class Occupancy(Field):
    """The share of the eight voxels round a place whose labels are drawn, by their trilinear weights: 0 to 1.

    Gradients are taken of their opacities, so that what borders on something more translucent has a surface, too.
    """

    name: ClassVar[str] = "occupancy"
    wgsl: ClassVar[str] = "field/occupancy.wgsl"
    cells: ClassVar[bool] = True
    smooth: ClassVar[bool] = False

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return nothing: the region stage has the labels."""
        return {}

    def for_empty(self) -> Field:
        """Return the field itself: voxels without a label are background."""
        return self

    def arranged(self, chosen: Mapping[str, Stage]) -> dict[str, Stage]:
        """Return a layer's stages by slot, with this field.

        Raises
        ------
        StageError
            When gradients are to be computed beforehand.
        """
        if chosen["gradient"].name == "precomputed":
            raise StageError(
                "look.gradient 'precomputed'", "does not follow labels that are shown and hidden", "use central or sobel"
            )
        return super().arranged(chosen)


def are_alone(labels: Labels | None, volume: Volume) -> bool:
    """Whether a layer's labels have no image: its volume is that of the labels."""
    return labels is not None and (labels.volume is volume or labels.volume == volume)
