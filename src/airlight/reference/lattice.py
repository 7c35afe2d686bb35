"""Where samples lie along rays: at equal distances from the eye, or where rays pass the planes of a slice driver."""

from __future__ import annotations

from ..scene import Camera
from ..stage import Context, Stage
from ..volume import FloatArray
from .setup import Setup


def lattice(
    driver: Stage | None,
    setup: Setup,
    camera: Camera,
    size: tuple[int, int],
    origin: FloatArray,
    direction: FloatArray,
    step_world: float,
) -> tuple[FloatArray | float, FloatArray | float]:
    """Return step and fraction of rays (n, 3): sample k lies at the distance ``(k + fraction) * step``, in world units.

    Planes ``dot(normal, p) = first + k * spacing`` are met at equal distances, the longer the more askew a ray is to them.
    """
    planes = getattr(driver, "planes", None)
    layer = setup.layer
    context = Context(layer.volume, setup.function, layer.channels, layer.time, step_world, size, layer.labels, camera)
    found = None if planes is None else planes(camera, context)
    if found is None:
        return step_world, 0.0
    per_spacing = found.spacing_world / (direction @ found.normal)
    return per_spacing, (found.first - origin @ found.normal) / found.spacing_world
