"""Pictures of a known error: steps are halved, pixel by pixel, until what changes is below a bound.

``docs/guide/known-error.md`` explains the estimate and what it was tested on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import StageError
from ..first_picture import resolve
from ..gpu.device import Device
from ..gpu.textures import Progress
from ..scene import Layer, Scene
from .annotating import annotated
from .background import plain_background
from .frame import Request, check_ended, draw_pixels
from .hits import Hits
from .image import FloatImage, Image

FIRST_STEP = 1 / 2  # voxels: a cell of the grid is seen from inside by nearly every ray that meets it
LEAST_STEP = 1 / 512
NEIGHBOURS_PX = 2
CHOSEN_LATER = ("transfer",)  # once it is known what kind of function there is


def draw_within(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Image:
    """Draw a frame whose pixels are all within a tolerance of what the scene converges to, or say which are not."""
    return deque(levels(device, scene, request, check, progress), maxlen=1).pop()


def levels(device: Device, scene: Scene, request: Request, check: Callable[[], None], progress: Progress) -> Iterator[Image]:
    """Draw a frame at half the step, again and again, where it still changes; ``stats["tolerance"]`` tells how far it is.

    A pixel's error at a step is estimated by the greater of its last two changes, of any channel, and by the greatest estimate
    of the pixels around it: a change alone may vanish by chance, or where all samples miss what is thin. Pixels whose rays
    take as many samples as at twice the step have nothing on their way.

    Raises
    ------
    StageError
        For tones that depend on the whole image.
    LimitError
        When the device ends rays at the first step.
    """
    assert request.tolerance is not None
    scene = resolve(scene, request.size_px)
    check_tones(scene)
    prepared, notes = annotated(scene, request.size_px)
    bounded = converging(prepared)
    asked = replace(request, driver=request.driver.converging(), tolerance=None, converges=True)
    known = Known(request.size_px, request.tolerance)
    step = FIRST_STEP
    while known.open.any() and step >= LEAST_STEP:
        pixels = None if known.open.all() else np.argwhere(known.open)[:, ::-1]
        told = _of_step(progress, step)
        part, samples = draw_pixels(device, bounded, replace(asked, step=step), check, told, pixels)
        if step == FIRST_STEP:
            check_ended(device, samples)
        known.take(step, part, samples)
        part.stats.pop("disagreement", None)  # of pixels with steps of their own
        yield replace(known.image(scene), stats=part.stats | notes.told | known.statistics(), marks=notes.marks)
        step /= 2


def _of_step(progress: Progress, step: float) -> Progress:
    """Progress that tells which of several pictures is drawn."""
    return lambda what, done, total: progress(f"{what}, step {step:g}" if what == "render" else what, done, total)


def check_tones(scene: Scene) -> None:
    """Refuse tones that depend on the whole image.

    Raises
    ------
    StageError
        Names the stage.
    """
    for layer in scene.visible_layers:
        if layer.look.tone.reads:
            where, found = f"look.tone {layer.look.tone.name!r}", "depends on the whole image, and pixels are drawn one by one"
            raise StageError(where, found, "use linear, or leave the tolerance out")


def converging(scene: Scene) -> Scene:
    """Return a scene whose stages are quick at no cost that smaller steps do not mend."""

    def drawn(layer: Layer) -> Layer:
        stages = {slot: stage.converging() for slot, stage in layer.look.stages().items() if slot not in CHOSEN_LATER}
        return replace(layer, look=replace(layer.look, **stages))

    return replace(scene, layers=tuple(drawn(layer) if layer.visible else layer for layer in scene.layers))


class Known:
    """What is known of an image whose pixels are drawn with smaller and smaller steps.

    Attributes
    ----------
    open
        Whether pixels (h, w) may be farther from the limit than the tolerance, and can be drawn with a smaller step.
    estimate
        Bound of the error of pixels (h, w), float32, of whichever channel; inf where nothing is known yet.
    """

    def __init__(self, size_px: tuple[int, int], tolerance: float) -> None:
        shape = size_px[::-1]
        self.tolerance = tolerance
        self.open = np.ones(shape, dtype=bool)
        self.estimate = np.full(shape, np.inf, dtype=np.float32)
        self._own, self._change = self.estimate.copy(), self.estimate.copy()
        self._rgba, self._depth = np.zeros((*shape, 4), np.float32), np.full(shape, np.inf, np.float32)
        self._hits: npt.NDArray[np.float32] | None = None
        self._samples = np.zeros(shape, dtype=np.float32)
        self._ended = np.zeros(shape, dtype=bool)
        self._steps: list[tuple[float, int]] = []
        self._taken = 0.0
        self._milliseconds: dict[str, float] = {}

    def take(self, step: float, part: Image, samples: FloatImage) -> None:
        """Take in what was drawn of the open pixels with a step [voxels], and how many samples (h, w) that took."""
        self._ended |= self.open & (samples < 0)
        drawn = np.flatnonzero(self.open & (samples >= 0))  # these are ten times as quick as a mask
        rgba, taken = listed(part.rgba).take(drawn, axis=0), listed(samples).take(drawn)
        if self._steps:
            change = reduce(np.maximum, np.abs(rgba - listed(self._rgba).take(drawn, axis=0)).T)
            same = taken == listed(self._samples).take(drawn)
            listed(self._own)[drawn] = np.maximum(change, np.where(same, 0, listed(self._change).take(drawn)))
            listed(self._change)[drawn] = change
        listed(self._rgba)[drawn], listed(self._samples)[drawn] = rgba, taken
        listed(self._depth)[drawn] = listed(part.depth).take(drawn)
        if part.hits is not None:
            self._hits = part.hits.array if self._hits is None else self._hits.copy()
            listed(self._hits)[drawn] = listed(part.hits.array).take(drawn, axis=0)
        if drawn.size:
            self._steps.append((step, len(drawn)))
        self._taken += part.stats.get("samples", 0)
        for name, spent in part.stats.get("milliseconds", {}).items():
            self._milliseconds[name] = self._milliseconds.get(name, 0.0) + spent
        self.estimate = greatest_around(self._own)
        self.open = (self.estimate > self.tolerance) & ~self._ended

    def image(self, scene: Scene) -> Image:
        """Return the image so far."""
        hits = None if self._hits is None else Hits(self._hits, scene)
        estimate = self.estimate.copy()
        return Image(self._rgba.copy(), self._depth.copy(), plain_background(scene), {}, hits, scene, estimate=estimate)

    def statistics(self) -> dict[str, Any]:
        """What ``image.stats`` says: estimates, which steps were taken [voxels] for how many pixels, and where it stopped."""
        over = int((self.estimate > self.tolerance).sum())
        if not over:
            stopped = "all pixels are within the tolerance"
        elif (self._ended & (self.estimate > self.tolerance)).any():
            stopped = f"{over} pixels are not within the tolerance: the device ended their rays, as its driver bounds loops"
        else:
            stopped = f"{over} pixels are not within the tolerance yet; the step is {self._steps[-1][0]:g} voxels"
        finite = np.where(np.isfinite(self.estimate), self.estimate, np.float32(1.0)).astype(np.float64)
        told = {
            "asked": self.tolerance,
            "maximum": float(finite.max()),
            "rms": float(np.sqrt((finite**2).mean())),
            "pixels_over": over,
            "pixels_by_step": dict(self._steps),
            "stopped": stopped,
        }
        return {"tolerance": told, "samples": int(self._taken), "milliseconds": dict(self._milliseconds)}


def listed(plane: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Pixels (h, w, ...) of a plane that lies in one piece as a list (h * w, ...), without a copy."""
    return plane.reshape(-1, *plane.shape[2:])


def greatest_around(estimate: FloatImage) -> FloatImage:
    """Greatest number of each pixel (h, w) and its neighbours up to ``NEIGHBOURS_PX`` away."""
    for axis in (0, 1):
        lines, found = np.moveaxis(estimate, axis, 0), estimate.copy()
        around = np.moveaxis(found, axis, 0)
        for away in range(1, NEIGHBOURS_PX + 1):
            np.maximum(around[away:], lines[:-away], out=around[away:])
            np.maximum(around[:-away], lines[away:], out=around[:-away])
        estimate = found
    return estimate
