"""Pictures in a given time: scale and step are chosen by what pixels and samples have cost so far."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Scene
from .annotating import annotated, noted
from .frame import Request, draw, explain
from .image import Image

# Scale of the picture and step [voxels], from the best picture to the quickest.
LADDER = ((1.0, 0.25), (1.0, 0.5), (1.0, 1.0), (1.0, 2.0), (0.7, 2.0), (0.5, 2.0), (0.35, 3.0), (0.25, 4.0), (0.125, 4.0))
PROBE_SCALE = 1 / 8
PROBE_STEPS = (1.0, 4.0)


@dataclass
class Cost:
    """What frames of one program take, in milliseconds: at all, for a pixel, and for a pixel at a step of a voxel."""

    frame_ms: float
    pixel_ms: float
    samples_ms: float

    def of(self, pixels: int, step: float) -> float:
        """Milliseconds of a frame."""
        return self.frame_ms + pixels * (self.pixel_ms + self.samples_ms / step)

    def learn(self, pixels: int, step: float, spent_ms: float) -> None:
        """Take a frame in: views differ, so that half of what it tells counts. No frame takes less than one at all."""
        self.frame_ms = min(self.frame_ms, spent_ms)
        expected = self.of(pixels, step) - self.frame_ms
        factor = (1 + min(max((spent_ms - self.frame_ms) / max(expected, 1e-6), 0.25), 4.0)) / 2
        self.pixel_ms *= factor
        self.samples_ms *= factor


def draw_in_time(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Image:
    """Draw the best picture that takes about ``request.budget_ms``; ``stats["budget"]`` tells what was chosen.

    What is drawn smaller is enlarged. The first frame of a program is drawn in small before, to measure it.
    """
    assert request.budget_ms is not None
    scene = resolve(scene, request.size_px)
    prepared, notes = annotated(scene, request.size_px)
    asked = replace(request, budget_ms=None)
    cost = _cost(device, prepared, asked, check, progress)
    scale, step = _chosen(cost, asked, request.budget_ms)
    size_px = scaled(request.size_px, scale)
    start = time.perf_counter()
    image = draw(device, prepared, replace(asked, size_px=size_px, step=step), check, progress)
    spent_ms = 1e3 * (time.perf_counter() - start)
    cost.learn(size_px[0] * size_px[1], step, spent_ms)
    told = {"asked_ms": request.budget_ms, "spent_ms": spent_ms, "scale": scale, "step": step}
    image = noted(enlarged(image, request.size_px), scene, notes)
    return replace(image, stats=image.stats | {"budget": told})


def scaled(size_px: tuple[int, int], scale: float) -> tuple[int, int]:
    """Size of a smaller picture."""
    width, height = size_px
    return max(1, round(width * scale)), max(1, round(height * scale))


def enlarged(image: Image, size_px: tuple[int, int]) -> Image:
    """Return an image in another size: colours interpolated, depths those of the nearest pixel.

    It has no hits, and no disagreement of neighbouring pixels.
    """
    from PIL import Image as Pillow

    if image.size == size_px:
        return image
    planes = [Pillow.fromarray(plane).resize(size_px, Pillow.Resampling.BILINEAR) for plane in np.moveaxis(image.rgba, -1, 0)]
    depth = Pillow.fromarray(image.depth).resize(size_px, Pillow.Resampling.NEAREST)
    rgba = np.stack([np.asarray(plane) for plane in planes], axis=-1)
    stats = {name: told for name, told in image.stats.items() if name != "disagreement"} | {"size": list(size_px)}
    return replace(image, rgba=rgba, depth=np.asarray(depth), stats=stats, hits=None)


def _chosen(cost: Cost, request: Request, budget_ms: float) -> tuple[float, float]:
    for scale, step in LADDER:
        width, height = scaled(request.size_px, scale)
        if step < getattr(request.driver, "least_step", 0.0):
            continue
        if cost.of(width * height, step) <= budget_ms and not (request.keep_hits and scale < 1):
            return scale, step
    return (1.0, LADDER[-1][1]) if request.keep_hits else LADDER[-1]


def _cost(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Cost:
    """What frames like this take, from before or measured on small ones."""

    def milliseconds(size_px: tuple[int, int], step: float) -> float:
        start = time.perf_counter()
        draw(device, scene, replace(request, size_px=size_px, step=step), check, progress)
        return 1e3 * (time.perf_counter() - start)

    def measured() -> Cost:
        small = scaled(request.size_px, PROBE_SCALE)
        milliseconds(small, PROBE_STEPS[0])  # compiles and uploads
        frame_ms = milliseconds((1, 1), PROBE_STEPS[0])
        near, far = (max(milliseconds(small, step) - frame_ms, 1e-3) / (small[0] * small[1]) for step in PROBE_STEPS)
        samples_ms = max(near - far, 0.0) / (1 / PROBE_STEPS[0] - 1 / PROBE_STEPS[1])
        return Cost(frame_ms, max(near - samples_ms, 0.0), samples_ms)

    key = explain(device, scene, request).key
    sizes = tuple(layer.volume.size for layer in scene.visible_layers)
    found: Cost = device.kept.get(("cost", key, sizes), measured)
    return found
