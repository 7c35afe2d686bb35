"""Several layers in one march: which are drawn, and what they must have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..errors import LimitError, StageError
from ..scene import Layer, Scene
from ..shader.program import Program
from ..stage import Context, Stage
from ..stages.driver import Driver
from ..stages.driver_slices import SliceDriver
from .resources import TEXTURES, DrawnLayer

if TYPE_CHECKING:
    from .march import MarchFrame

MOST_LAYERS = 8
SHARED = ("integrate", "tone")
APART = "emission_absorption, first_hit, weighted_sum or xray for all, or projections of values for all"


def checked_layers(scene: Scene) -> tuple[Layer, ...]:
    """Layers that are drawn together.

    Raises
    ------
    LimitError
        When there are more than one march takes.
    StageError
        When they ask for different stages where a ray has one.
    """
    drawn = scene.drawn_layers
    if len(drawn) > MOST_LAYERS:
        raise LimitError("scene.layers", f"has {len(drawn)} visible layers, one march takes {MOST_LAYERS}", "hide the others")
    first, own = drawn[0], own_slots(drawn)
    for layer in drawn[1:]:
        where = f"scene.layers[{next(n for n, one in enumerate(scene.layers) if one is layer)}]"
        for slot in SHARED:
            mine, others = getattr(layer.look, slot), getattr(first.look, slot)
            if mine != others and slot not in own:
                found = (
                    f"is {mine.name} {mine}" if mine.name == others.name else f"is {mine.name}, that of another {others.name}"
                )
                remedy = f"use {APART}" if slot == "integrate" else "give all layers the same"
                raise StageError(f"{where}.look.{slot}", f"{found}; a ray has one", remedy)
    return drawn


def own_slots(layers: Sequence[Layer]) -> frozenset[str]:
    """Slots of a ray that each of several layers fills by itself: projections, surfaces, and what dims its light."""
    if len(layers) == 1:
        return frozenset()
    integrates = [layer.look.integrate for layer in layers]
    one_kind = all(getattr(one, "surfaces_only", False) and type(one) is type(integrates[0]) for one in integrates)
    dims = any(layer.look.visibility.name != "none" for layer in layers)
    return frozenset(["integrate"] * (one_kind or all(map(shows_values, integrates))) + ["visibility"] * dims)


def shows_values(integrate: Stage) -> bool:
    """Whether a stage looks at values of a ray, and neither at slabs nor at surfaces."""
    slabs = getattr(integrate, "classifies", True) or getattr(integrate, "surfaces_only", False)
    return getattr(integrate, "uses_values", True) and not slabs


def marched_apart(layers: Sequence[DrawnLayer]) -> bool:
    """Whether each layer has rays of its own."""
    return "integrate" in layers[0].stages and shows_values(layers[0].stages["integrate"])


def read_layers(layers: tuple[Layer, ...], driver: Stage) -> tuple[Layer, ...]:
    """Layers with the fields that a driver reads in the place of theirs.

    Raises
    ------
    StageError
        For fields that it cannot read.
    """
    if not isinstance(driver, Driver):
        return layers

    def read(layer: Layer) -> Layer:
        stages = layer.look.stages()
        lighting, integrate = stages["lighting"], stages["integrate"]
        at_ends = lighting.name == "unlit" or getattr(lighting, "lights_ends", False)
        between = getattr(stages["modulation"], "uses_gradient", False) or getattr(integrate, "surfaces_only", False)
        on_layers = len(layers) == 1 and at_ends and not between and not getattr(layer.transfer, "surfaces", ())
        field = driver.field_for(layer.look.field, on_layers)
        return layer if field is layer.look.field else replace(layer, look=replace(layer.look, field=field))

    return tuple(read(layer) for layer in layers)


def context_of(layer: Layer, step_world: float, size_px: tuple[int, int], **told: Any) -> Context:
    """What stages may look at of a layer in a frame; ``told`` are further fields of it."""
    return Context(layer.volume, layer.function, layer.channels, layer.time, step_world, size_px, layer.labels, **told)


def check_layers(frame: MarchFrame) -> None:
    """Refuse stages that cannot look at several layers.

    Raises
    ------
    StageError
        For what shows one value of a ray, and projections in slices.
    LimitError
        Where clips of some layers meet slices.
    """
    if len(frame.layers) == 1:
        return
    integrate, driver = frame.scene_stages["integrate"], frame.scene_stages["driver"]
    apart = marched_apart(frame.layers)
    if getattr(integrate, "uses_values", True) and not getattr(integrate, "surfaces_only", False) and not apart:
        what = f"looks at one volume, and {len(frame.layers)} layers are visible"
        raise StageError(f"look.integrate {integrate.name!r}", what, "use emission_absorption or first_hit, or hide the others")
    if apart and isinstance(driver, SliceDriver):
        what = f"projects one layer, and {len(frame.layers)} are visible"
        raise StageError(f"driver {driver.name!r}", what, "use driver='march', or hide the others")
    if len(frame.clip_groups) > 1 and isinstance(driver, SliceDriver):
        what = f"cut some layers alone, which the driver {driver.name!r} cannot"
        raise LimitError("layer.clips", what, "use driver='march', or scene.clips for all layers")


def layer_statistics(frame: MarchFrame) -> dict[str, Any]:
    """What ``image.stats`` says of several layers: how many are drawn, and how exactly surfaces are looked for."""
    if len(frame.layers) == 1:
        return {}
    if marched_apart(frame.layers):
        return {"several": {"layers": len(frame.layers), "projections": "added"}}
    surfaces = bool(getattr(frame.scene_stages["integrate"], "surfaces_only", False))
    way = "at samples, sharpened" if surfaces else "by straight lines between samples"
    told = {"layers": len(frame.layers), "slabs": "mixed evenly", "surfaces": way}
    dimmed = any("visibility" in layer.stages for layer in frame.layers)
    return {"several": told | ({"visibility": "by all layers"} if dimmed else {})}


def check_textures(frame: MarchFrame, program: Program) -> None:
    """Refuse more textures and samplers than a device gives to one program.

    Raises
    ------
    LimitError
        When several layers need more.
    """
    if len(frame.layers) == 1:
        return
    for what, kinds in (("sampled-textures", TEXTURES), ("samplers", ("sampler",))):
        most = frame.device.limits[f"max-{what}-per-shader-stage"]
        count = sum(binding.kind in kinds for binding in program.bindings)
        if count > most:
            raise LimitError(
                "scene.layers",
                f"are {len(frame.layers)} with {count} {what.split('-')[-1]}, and {frame.device.info.name} takes {most}",
                "hide some, or use skip='none' and transfer='postclassified', which take fewer",
            )
