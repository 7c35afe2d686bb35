"""What a march has found at surfaces, kept so that changed lights and materials need no other march."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError, StageError
from ..gpu import compute
from ..scene import Layer, Scene
from ..stages import tone as tones
from .resources import bound_resources, pack_uniforms, uniform_values, write_lights

if TYPE_CHECKING:
    from .march import MarchFrame

HIT_BYTES = 32
LIT_AT_POINTS = ("unlit", "sampled", "supersampled", "averaged", "interpolated")


@dataclass(frozen=True, eq=False)
class Hits:
    """Surfaces as they were met by the rays of an image.

    Attributes
    ----------
    array
        float32 (height, width, 8): gradient in the world, value; distance from the eye on the device, side, number of the
        visible layer, unused.
        The side is 0 where there is no surface, 1 where the ray went up through the value, 2 down, 3 where it began inside;
        4 where no surfaces are looked for, and opacity passes one half.
    scene
        What was drawn, with its camera.
    """

    array: npt.NDArray[np.float32]
    scene: Scene

    @property
    def normal(self) -> npt.NDArray[np.float32]:
        """float32 (height, width, 3): unit normals in the world, towards lower values; 0 where there is none."""
        gradient = self.array[..., :3].astype(np.float64)
        length = np.linalg.norm(gradient, axis=-1, keepdims=True)
        return np.where(length > 0, -gradient / np.where(length > 0, length, 1.0), 0.0).astype(np.float32)

    @property
    def side(self) -> npt.NDArray[np.uint8]:
        """uint8 (height, width): 0 nothing, 1 met on the way up, 2 down, 3 the ray began inside, 4 half opaque."""
        return self.array[..., 5].astype(np.uint8)

    @property
    def layer(self) -> npt.NDArray[np.uint8]:
        """uint8 (height, width): number of the visible layer that was met, or is the most opaque one; 0 for nothing."""
        return np.array(_drawn_numbers(self.scene), dtype=np.uint8)[self.array[..., 6].astype(np.intp)]


def check_keeps(frame: MarchFrame) -> None:
    """Refuse to keep what is not there, and surfaces that could not be lit again.

    Raises
    ------
    StageError
        When rays neither look for surfaces nor for where opacity passes one half, and see ``check_relights``.
    """
    integrate = frame.scene_stages["integrate"]
    if getattr(integrate, "surfaces_only", False):
        check_relights(frame)
    elif not getattr(integrate, "uses_slabs", False):
        what = "meets no surfaces that could be kept"
        raise StageError(f"look.integrate {integrate.name!r}", what, "use first_hit or emission_absorption")


def check_relights(frame: MarchFrame) -> None:
    """Refuse to light what has not all that light asks for.

    Raises
    ------
    StageError
        When no surfaces are looked for, values are several numbers, or light depends on more than is kept.
    """
    integrate = frame.scene_stages["integrate"]
    if not getattr(integrate, "surfaces_only", False):
        raise StageError(f"look.integrate {integrate.name!r}", "meets no surfaces that could be lit again", "use first_hit")
    for layer in frame.layers:
        lighting = layer.stages["lighting"]
        if layer.field.groups(layer.context):
            raise StageError(f"look.field {layer.field.name!r}", "has several numbers at a surface", "draw one channel")
        if lighting.name == "unlit" and getattr(layer.stages["shade"], "lit", True):
            raise StageError("look.lighting 'unlit'", "leaves out the light of a stage that has some", "use shade='none'")
        if lighting.name not in LIT_AT_POINTS:
            raise StageError(f"look.lighting {lighting.name!r}", "cannot light what was kept", "use sampled")


def check_same(hits: Hits, scene: Scene, size_px: tuple[int, int]) -> None:
    """Refuse a scene whose surfaces are not those that were kept.

    Raises
    ------
    DataError
        Names what is another.
    """
    if _drawn_numbers(hits.scene) != _drawn_numbers(scene):
        raise DataError("scene", "shows other layers than the image", "render it")
    for one, other in zip(hits.scene.drawn_layers, scene.drawn_layers, strict=True):
        found = _differs(hits.scene, one, scene, other)
        if found:
            raise DataError("scene", f"has another {found} than the image, whose surfaces lie elsewhere", "render it")


def _drawn_numbers(scene: Scene) -> list[int]:
    """Numbers, among the visible layers, of those that are drawn."""
    drawn = scene.drawn_layers
    return [n for n, layer in enumerate(scene.visible_layers) if any(layer is one for one in drawn)]


def _differs(kept: Scene, one: Layer, scene: Scene, other: Layer) -> str | None:
    """Return what moves the surfaces of a layer."""
    drawn, asked = (layer.stages(keeps_gradient=True) for layer in (one, other))
    others = {
        "camera": kept.camera != scene.camera,
        "volume": one.volume is not other.volume,
        "labels": one.labels != other.labels,
        "clip": kept.clips_of(one) != scene.clips_of(other),
        "time or channel": (one.time, one.channels) != (other.time, other.channels),
        **{slot: drawn[slot] != asked[slot] for slot in ("field", "gradient", "integrate")},
    }
    iso = getattr(one.look.integrate, "iso", None)
    if iso is None:
        values = [getattr(layer.function, "half_extinction_value", None) for layer in (one, other)]
        others["iso-value"] = values[0] != values[1]
    return next((name for name, differs in others.items() if differs), None)


def light_again(frame: MarchFrame, bands: Iterable[Any]) -> None:
    """Light the surfaces in the buffers ``hits`` of bands of rows."""
    device = frame.device
    instead: dict[str, Any] = {"tone": tones.Linear()} if frame.tones_late else {}
    program = frame.program("passes/relight.wgsl", ("radiance", "depth", "hits"), **instead)
    pipeline = compute.pipeline_of(device, program)
    values = uniform_values(device, frame.scene_stages, frame.layers, frame.anchor_world, frame.progress) | instead
    views = bound_resources(device, program, frame.layers, frame.scene_resources, frame.anchor_world, frame.progress)
    assert frame.found is not None
    for band in bands:
        rows = np.ascontiguousarray(frame.found.array[band.first_row : band.first_row + band.rows])
        device.queue.write_buffer(band.hits, 0, rows)
        bound = {
            **views,
            "radiance": band.radiance,
            "depth": band.depth,
            "hits": band.hits,
            "uniforms": compute.write_uniforms(device, "uniforms of relight", pack_uniforms(program, band.uniforms(), values)),
            "lights": write_lights(device, frame.scene.lights),
        }
        groups = compute.bind_groups(device, pipeline, bound)
        compute.dispatch_pixels(device, pipeline, groups, frame.size_px[0], band.rows)
