"""What of a place is drawn, and in which tint: regions of labels beside the image."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ..errors import StageError
from ..labels import Labels, label_numbers, styles_table
from ..stage import Context, LabelCells, Mat4f, Resource, Stage, Table, Vec3f, param, register
from ..transfer import TransferFunction
from ..transfer.kinds import DrawnFunction
from ..transfer.regions import ByRegion
from .field_labels import Occupancy, are_alone


@dataclass(frozen=True, eq=False)
class RegionUniforms:
    """The way from the layer's index coordinates to the texels of labels, and the last texel."""

    texel_from_index: Mat4f = param(None)
    last_texel: Vec3f = param((1.0, 1.0, 1.0), unit="voxel")


@register
@dataclass(frozen=True)
class Whole(Stage):
    """All of the layer, as it is: a layer without labels."""

    slot: ClassVar[str] = "region"
    name: ClassVar[str] = "whole"
    wgsl: ClassVar[str] = "region/whole.wgsl"


@register
@dataclass(frozen=True)
class Labelled(Stage):
    """The styles of the eight labels round a place, mixed by their trilinear weights: borders are smooth, and no label is."""

    slot: ClassVar[str] = "region"
    name: ClassVar[str] = "labelled"
    wgsl: ClassVar[str] = "region/labelled.wgsl"
    uniform_type: ClassVar[type] = RegionUniforms

    def uniforms(self, context: Context) -> Any:
        """Return the place of the labels in the layer's grid."""
        volume = labels_of(context).volume
        # Texels begin with one of background.
        texel_from_index = volume.index_from_world @ context.volume.world_from_index
        texel_from_index[:3, 3] += 1
        x, y, z = (float(n + 1) for n in volume.size)
        return RegionUniforms(texel_from_index, (x, y, z))

    def variant(self, context: Context) -> dict[str, bool]:
        """Return whether regions have functions of their own, and whether there is no image."""
        alone = are_alone(context.labels, context.volume)
        return {"own_functions": isinstance(context.transfer, ByRegion), "alone": alone}

    def resources(self, context: Context) -> Mapping[str, Resource]:
        """Return the labels, and the styles of those that occur."""
        labels = labels_of(context)
        time = labels.time_of(context.time)
        numbers = label_numbers(labels.volume, time, labels.background)
        return {"cells": LabelCells(numbers), "styles": Table(styles_table(labels, time))}


def labels_of(context: Context) -> Labels:
    """Return the layer's labels.

    Raises
    ------
    StageError
        When it has none.
    """
    if context.labels is None:
        raise StageError("region.labelled", "asks for labels, and the layer has none", "give it some: Layer(labels=...)")
    return context.labels


def for_labels(labels: Labels | None, function: DrawnFunction, chosen: Mapping[str, Stage]) -> Stage:
    """Return the stage that draws a layer's labels, or the whole layer where there are none.

    Raises
    ------
    StageError
        When what is gathered along a ray has no regions, or a stage or the function does not go with labels.
    """
    if labels is None:
        return Whole()
    integrate, transfer = chosen["integrate"], chosen["transfer"]
    if isinstance(function, ByRegion) and isinstance(chosen["field"], Occupancy):
        raise StageError("labels.styles", "have transfer functions, and the layer has no image", "use colours")
    if isinstance(function, ByRegion) and not getattr(transfer, "of_regions", False):
        remedy = "use linear or nearest, or leave these functions out"
        raise StageError(
            f"look.field {chosen['field'].name!r}", "cannot draw labels with transfer functions of their own", remedy
        )
    if isinstance(function, ByRegion) and not getattr(integrate, "classifies", True):
        raise StageError(
            f"look.integrate {integrate.name!r}", "draws no transfer functions of labels", "use emission_absorption"
        )
    if isinstance(function, TransferFunction) and function.surfaces:
        raise StageError("layer.transfer", "has surfaces, which labels do not hide or tint yet", "leave out one of the two")
    if not (getattr(integrate, "uses_slabs", True) or getattr(integrate, "classifies", True)):
        remedy = "use emission_absorption or first_hit, or leave the labels out"
        raise StageError(f"look.integrate {integrate.name!r}", "gathers values, and labels tint and hide what is drawn", remedy)
    return Labelled()
