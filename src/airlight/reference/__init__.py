"""The definition of right: a volume renderer in NumPy, float64, written to be read.

It shares no code with the device half, and neither is generated from the other. Read ``march.py`` first, then one module a
slot. ``register`` gives a stage from outside its function here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..environment import Environment
from ..errors import DataError, StageError
from ..scene import Layer, Scene, fit_camera
from ..stage import Stage, make_stage
from ..stages.driver_half_angle import HalfAngle
from ..volume import FloatArray
from . import channels as _channels  # noqa: F401  (its functions put themselves into TRANSFERS)
from . import levels as _levels  # noqa: F401  (its functions put themselves into FIELDS and DERIVATIVES)
from . import occlusion as _occlusion  # noqa: F401  (it puts its function into VISIBILITIES)
from . import projections as _projections  # noqa: F401  (its classes put themselves into INTEGRATES)
from . import quantised as _quantised  # noqa: F401  (it puts its function into LIGHTINGS)
from . import shadows as _shadows  # noqa: F401  (it puts its function into VISIBILITIES)
from .camera import CAMERAS
from .covers import covers, surface_setup
from .environment import seen
from .field import FIELDS
from .gradient import GRADIENTS
from .half_angle import TRANSPORTS
from .integrate import INTEGRATES
from .lattice import lattice
from .layers import march_layers
from .march import march
from .modulation import MODULATIONS
from .passes import PASSES, Picture
from .region import REGIONS
from .setup import Setup
from .shade import LIGHTINGS, SHADES, VISIBILITIES
from .tone import TONES
from .transfer import TRANSFERS

__all__ = ["TABLES", "ReferenceImage", "converged", "prepare", "register", "render"]

# Function of each stage, by slot and name.
TABLES: dict[str, dict[str, Any]] = {
    "camera": CAMERAS,
    "field": FIELDS,
    "gradient": GRADIENTS,
    "transfer": TRANSFERS,
    "modulation": MODULATIONS,
    "region": REGIONS,
    "shade": SHADES,
    "visibility": VISIBILITIES,
    "transport": TRANSPORTS,
    "lighting": LIGHTINGS,
    "integrate": INTEGRATES,
    "tone": TONES,
    "passes": PASSES,
}

RAYS_AT_ONCE = 16384

Fraction = Callable[[npt.NDArray[np.int64], npt.NDArray[np.int64]], npt.ArrayLike]


@dataclass(frozen=True, eq=False)
class ReferenceImage:
    """``rgba`` (height, width, 4), float64, premultiplied, linear, after tone; ``depth`` (height, width), inf where none.

    Of chosen pixels: (n, 4) and (n,).
    """

    rgba: FloatArray
    depth: FloatArray


def register(slot: str, name: str, function: Any) -> None:
    """Give a stage its function, as its slot's module describes it (integrate: a class).

    Raises
    ------
    StageError
        For a slot that does not exist.
    """
    if slot not in TABLES:
        raise StageError(f"reference.{slot}", "is no slot", "choose one of " + ", ".join(TABLES))
    TABLES[slot][name] = function


def render(
    scene: Scene,
    size: tuple[int, int],
    *,
    step: float = 1.0,
    substeps: int | None = None,
    progress: Callable[[float], None] | None = None,
    pixels: npt.ArrayLike | None = None,
    offset_fraction: Fraction | None = None,
    curved: bool = True,
    refine: str = "bisection",
    blocks: bool = True,
    mesh_layers: int | None = None,
    adaptive: bool = False,
    driver: Stage | None = None,
    passes: Sequence[Stage] = (),
) -> ReferenceImage:
    """Render a scene.

    Of several layers surfaces are found within slabs by straight lines, and first hits at samples alone, not in each block.

    Parameters
    ----------
    scene
        What is drawn, without annotations; its layers' transfer functions must be given.
    size
        Width and height in pixels.
    step
        Distance of samples in units of the smallest voxel spacing.
    substeps
        Cut each step into so many; the lattice keeps its samples.
    progress
        Called with the share that is done, in (0, 1].
    pixels
        Pixels (n, 2) to be computed, as (x, y); None is all.
    offset_fraction
        Called with x and y of pixels; the fraction of a step by which samples of each are shifted away from the eye.
    curved
        Whether values are put right for the field's curvature along rays where the stages gain from it, as the driver's option
        of that name does; ``converged`` never does.
    refine
        How the place of a surface between two samples is sharpened: none, bisection, secant or exact.
    mesh_layers
        Most semi-transparent layers of meshes that a ray meets; None is all.
    blocks
        Whether rays that look for surfaces are sampled in each block of voxels, whatever the step.
    adaptive
        Whether slabs of a scene of one layer are longer where little of them gets through to the eye.
    driver
        A driver on whose slices samples lie, instead of at equal distances from the eye; nothing else of it counts.
    passes
        What is made of the picture in the end, of all its pixels.

    Raises
    ------
    DataError
        When the scene has no visible layer, one without a transfer function, or a stage has no function here.
    """
    if isinstance(driver, HalfAngle):
        raise DataError("driver", "makes shadows, which are rendered elsewhere", "use reference.half_angle.render")
    setups = prepare_layers(scene)
    step /= substeps or 1
    options = (curved, refine, blocks, mesh_layers, adaptive, driver, _known(passes, pixels))
    return _image(scene, setups, size, step, pixels, progress, offset_fraction, *options)


def converged(
    scene: Scene, size: tuple[int, int], *, pixels: npt.ArrayLike | None = None, step: float = 1 / 16
) -> ReferenceImage:
    """Render with tiny steps, the exact integral over each slab, and rays that never end early."""
    return _image(scene, tuple(_exact(setup) for setup in prepare_layers(scene)), size, step, pixels)


def _exact(setup: Setup) -> Setup:
    exact = dict(setup.stages)
    if exact["transfer"].name == "postclassified":
        exact["transfer"] = make_stage("transfer", "preintegrated")
    if hasattr(exact["integrate"], "opaque_at"):
        exact["integrate"] = replace(exact["integrate"], opaque_at=1.0)
    return replace(setup, stages=exact, beside=tuple(_exact(other) for other in setup.beside))


def prepare(scene: Scene) -> Setup:
    """Return what the stages see of a scene of one visible layer."""
    if len(scene.visible_layers) != 1:
        raise DataError("scene.layers", f"has {len(scene.visible_layers)} visible layers, and one is asked for")
    return prepare_layers(scene)[0]


def prepare_layers(scene: Scene) -> tuple[Setup, ...]:
    """Return what the stages see of each layer of a scene that is drawn."""
    setups = tuple(_setup_of(scene, layer) for layer in scene.drawn_layers)
    if not setups:
        raise DataError("scene.layers", "has no visible layer")
    least = min(setup.spacing_world for setup in setups)
    if len(setups) == 1:
        return setups
    integrate = INTEGRATES[setups[0].stages["integrate"].name]
    together = setups if integrate.uses_slabs or integrate.has_surface else ()
    return tuple(
        replace(setup, least_spacing_world=least, beside=tuple(other for other in together if other is not setup))
        for setup in setups
    )


def _setup_of(scene: Scene, layer: Layer) -> Setup:
    if layer.transfer is None:
        raise DataError("layer.transfer", "is None, and the reference chooses no function", "pass a TransferFunction")
    stages = layer.stages()
    for slot, stage in stages.items():
        if slot in TABLES and stage.name not in TABLES[slot]:
            raise DataError(f"look.{slot}", f"is {stage.name}, which has no function here", "use reference.register")
    return Setup(layer, layer.function, stages, scene.lights, clips=scene.clips_of(layer))


def _known(passes: Sequence[Stage], pixels: npt.ArrayLike | None) -> Sequence[Stage]:
    """Return passes that have a function here, over whole pictures."""
    for one in passes:
        if one.name not in PASSES:
            raise DataError(f"pass {one.name!r}", "has no function here", "use reference.register")
    if passes and pixels is not None:
        raise DataError("pixels", "were chosen, but passes look at the whole image", "leave them out")
    return passes


def _image(
    scene: Scene,
    setups: tuple[Setup, ...],
    size: tuple[int, int],
    step: float,
    pixels: npt.ArrayLike | None,
    progress: Callable[[float], None] | None = None,
    offset_fraction: Fraction | None = None,
    curved: bool = False,
    refine: str = "bisection",
    blocks: bool = True,
    mesh_layers: int | None = None,
    adaptive: bool = False,
    driver: Stage | None = None,
    passes: Sequence[Stage] = (),
) -> ReferenceImage:
    # Choose the camera.
    (width, height), camera, tone = size, scene.camera, setups[0].stages["tone"]
    if isinstance(camera, str):
        corners = [s.layer.volume.corners_world(bool(getattr(s.stages["field"], "cells", False))) for s in setups]
        camera = fit_camera(camera, np.concatenate(corners), aspect=width / height)
    setups = tuple(replace(setup, camera=camera, size_px=size) for setup in setups)
    setup = setups[0]
    # List the pixels, first row on top.
    y, x = (axis.ravel() for axis in np.indices((height, width)))
    if pixels is not None:
        if tone.reads:
            raise DataError("pixels", f"were chosen, but tone {tone.name} needs the whole image", "leave them out")
        x, y = np.asarray(pixels, dtype=np.int64).reshape(-1, 2).T
    # March the rays of one chunk of pixels after the other.
    rgba, depth, backdrop = np.empty((len(x), 4)), np.empty(len(x)), np.zeros(len(x))
    for first in range(0, len(x), RAYS_AT_ONCE):
        part = slice(first, first + RAYS_AT_ONCE)
        origin, direction = CAMERAS[camera.name](camera, size, x[part], y[part])
        step_world, fraction = lattice(driver, setup, camera, size, origin, direction, step * setup.finest_world)
        if offset_fraction is not None:
            fraction = fraction + np.asarray(offset_fraction(x[part], y[part]), dtype=np.float64)
        found = covers(scene, surface_setup(setup), origin, direction, mesh_layers) if scene.meshes else None
        if len(setups) == 1:
            result = march(setup, origin, direction, step_world, fraction, curved, refine, blocks, found, adaptive)
        else:
            result = march_layers(setups, origin, direction, step_world, fraction, curved, found, refine)
        rgba[part, :3], rgba[part, 3], depth[part] = result.rgb, result.alpha, result.t_world
        if isinstance(scene.background, Environment):
            looks = np.flatnonzero(direction.any(axis=1))
            behind = (1 - result.alpha[looks])[:, None] * seen(scene.background, direction[looks])
            backdrop[part] = 1 - result.alpha
            rgba[first + looks] = np.column_stack([result.rgb[looks] + behind, np.ones(len(looks))])
        if progress is not None:
            progress(min(1.0, (first + RAYS_AT_ONCE) / len(x)))
    # Put the pixels in rows and map the tones.
    shape = (height, width) if pixels is None else (len(x),)
    rgba, depth = rgba.reshape(*shape, 4), depth.reshape(shape)
    for what in ("scene", "display"):
        for one in passes:
            if getattr(one, "over", "display") == what:
                picture = Picture(rgba, backdrop.reshape(shape), depth, camera, setups, driver, step * setup.finest_world)
                rgba = PASSES[one.name](one, picture)
        rgba = TONES[tone.name](tone, rgba) if what == "scene" else rgba
    return ReferenceImage(rgba, depth)
