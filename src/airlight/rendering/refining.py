"""Pictures that get better: small ones first, then smaller steps, until all pixels are within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Scene
from .annotating import annotated, noted
from .budget import enlarged, scaled
from .frame import Request, draw
from .image import Image
from .tolerance import check_tones, levels

FIRST_PICTURES = ((0.25, 2.0), (0.5, 2.0), (1.0, 1.0))
"""Scale and step [voxels] of what is shown before errors are estimated."""


def better_and_better(
    device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress
) -> Iterator[Image]:
    """Draw a scene coarsely, then finer and finer; ``stats["refined"]`` tells scale and step, the last image is the best."""
    scene = resolve(scene, request.size_px)
    check_tones(scene)
    prepared, notes = annotated(scene, request.size_px)
    first = replace(request, tolerance=None)
    for scale, step in FIRST_PICTURES:
        keeps = request.keep_hits and scale == 1
        asked = replace(first, size_px=scaled(request.size_px, scale), step=step, keep_hits=keeps)
        image = noted(enlarged(draw(device, prepared, asked, check, progress), request.size_px), scene, notes)
        yield replace(image, stats=image.stats | {"refined": {"scale": scale, "step": step}})
    for image in levels(device, scene, request, check, progress):
        finest = min(image.stats["tolerance"]["pixels_by_step"])
        yield replace(image, stats=image.stats | {"refined": {"scale": 1.0, "step": finest}})
