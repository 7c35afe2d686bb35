"""What hides light from a layer: cells of its own, and those of the other layers of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..gpu import compute, textures
from ..gpu.device import Device
from ..shader.program import LayerUniforms, ProgramKey, StageKey, Switches, build_program
from ..stage import F32, U32, Mat4f, OccluderGrid, Stage, Vec3f, param
from ..stages.visibility import occluders_of
from ..volume import FloatArray, Volume, domain_index
from .layers import marched_apart
from .occluders import Hider, occluder_texture
from .resources import DrawnLayer


@dataclass(frozen=True, eq=False)
class HidesUniforms:
    """Cells of a layer as those of another see them: domain and ``last``, where the volume ends, in cells of its own."""

    from_cells: Mat4f = param(None)
    low: Vec3f = param((0.0, 0.0, 0.0), unit="cell")
    high: Vec3f = param((1.0, 1.0, 1.0), unit="cell")
    last: Vec3f = param((1.0, 1.0, 1.0), unit="cell")
    unit_per_cell: Vec3f = param((1.0, 1.0, 1.0), unit="1/cell")
    cell_world: F32 = param(1.0, unit="world")
    step_world: F32 = param(1.0, unit="world")
    steps: U32 = param(1)


class Hides(Stage):
    """A layer on the ways from cells to light; it is no stage that a look could have."""

    slot: ClassVar[str] = "hides"
    name: ClassVar[str] = "hides"
    wgsl: ClassVar[str] = "hides.wgsl"
    uniform_type: ClassVar[type] = HidesUniforms


def hiders(layers: Sequence[DrawnLayer], number: int, grid: OccluderGrid) -> tuple[Hider, ...]:
    """Layers that hide light from one of them, that one with its cells first.

    The others have as many cells along their longest side as that asks for, and the same tint. Projections are shown each by
    itself.
    """
    own = layers[number]
    others = () if marched_apart(layers) else (layer for layer in layers if layer is not own)
    return Hider(own, grid), *(Hider(layer, occluders_of(layer.context, grid.asked, grid.tint)) for layer in others)


def cells_from_world(grid: OccluderGrid, volume: Volume) -> FloatArray:
    """Way from the world to cells, counted from the corner of the volume."""
    middle = np.eye(4)
    middle[:3, 3] = 0.5
    return np.asarray(np.diag([*(1 / n for n in grid.block), 1.0]) @ middle @ volume.index_from_world)


def cell_domain(grid: OccluderGrid, volume: Volume, to_faces: bool) -> list[Any]:
    """Least and greatest places, in cells, at which a field has values."""
    return [tuple((edge + 0.5) / np.array(grid.block)) for edge in domain_index(volume.size, to_faces)]


def hides_uniforms(seen: Hider, own: Hider, length_world: float = 1.0) -> HidesUniforms:
    """Cells of a layer as those of ``own`` see them, and even steps through a length."""
    grid, volume = seen.grid, seen.layer.context.volume
    to_world = np.linalg.inv(cells_from_world(own.grid, own.layer.context.volume))
    low, high = cell_domain(grid, volume, seen.layer.field.cells)
    steps = steps_through(grid, own.grid, length_world)
    return HidesUniforms(
        from_cells=np.eye(4) if seen is own else cells_from_world(grid, volume) @ to_world,
        low=low,
        high=high,
        last=tuple(np.array(volume.size) / grid.block),
        unit_per_cell=tuple(1 / n for n in grid.cells),  # type: ignore[arg-type]
        cell_world=grid.cell_world,
        step_world=length_world / steps,
        steps=steps,
    )


def steps_through(grid: OccluderGrid, own: OccluderGrid, length_world: float) -> int:
    """Even steps through a length, of at most a cell's side; finer cells than the layer's own take half a side of those."""
    return max(1, int(np.ceil(length_world / max(grid.cell_world, own.cell_world / 2))))


@dataclass(frozen=True, eq=False)
class HidingPass:
    """A pass through the cells of layers: its program, what is bound, and the values of its uniforms."""

    program: Any
    bound: dict[str, Any]
    values: dict[str, Any]


def hiding_pass(
    device: Device,
    root: str,
    seen: Sequence[Hider],
    own: Hider,
    outputs: tuple[str, ...],
    extra: tuple[str, ...],
    anchor_world: FloatArray,
    progress: textures.Progress,
    length_world: float = 1.0,
) -> HidingPass:
    """Return a pass that looks through the cells of these layers, from cells of ``own``."""
    key = ("hides", StageKey(Hides, (), (("occluders", "openness"),)))
    program = build_program(
        ProgramKey(f"passes/{root}.wgsl", (), ((key,),) * len(seen), outputs, extra, Switches(), device.traits)
    )
    bound: dict[str, Any] = {}
    values: dict[str, Any] = {}
    for i, one in enumerate(seen):
        texture = occluder_texture(device, one.grid, one.layer, anchor_world, progress)
        bound |= {f"hides_occluders_{i}": texture.create_view(), f"hides_occluders_{i}_sampler": compute.linear_sampler(device)}
        values |= {f"hides_{i}": hides_uniforms(one, own, length_world), f"layer_{i}": UNASKED}
    return HidingPass(program, bound, values)


UNASKED = LayerUniforms(
    index_from_world=np.eye(4), gradient_world_from_index=np.eye(3), channel_scale=np.eye(4), channel_offset=np.eye(4)
)
