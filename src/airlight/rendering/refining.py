"""Pictures that get better: small ones first, then smaller steps, until all pixels are within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

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


def silent(_what: str, _done: int, _total: int) -> None:
    """Tell nobody of progress."""


@dataclass(eq=False)
class _Asked:
    """Whoever asks for the next image of a refinement: what may raise between tiles, and is told of progress."""

    check: Callable[[], None] = lambda: None
    progress: Progress = silent


class Refinement:
    """Images of one scene that get better, as far as they are; advanced on the render thread alone.

    ``reader`` is the iteration that they are for.
    """

    def __init__(self, what: tuple[Scene, Request, bool]) -> None:
        self.what = what
        self.last: Image | None = None
        self.reader: object = None
        self._device: Device | None = None
        self._images: Iterator[Image] | None = None
        self._asked = _Asked()  # a value of its own: images that lead back to here would be a ring, which keeps volumes

    def next(self, device: Device, check: Callable[[], None], progress: Progress) -> Image | None:
        """Return the next image, None behind the last. Work that is given up, or whose device is lost, begins anew."""
        asked = self._asked
        if self._images is None or self._device is not device:
            self._device = device
            self._images = better_and_better(device, *self.what, lambda: asked.check(), lambda *told: asked.progress(*told))
        asked.check, asked.progress = check, progress
        try:
            self.last = next(self._images)
        except StopIteration:
            return None
        except BaseException:
            self._images = self.last = None
            raise
        finally:
            asked.check, asked.progress = lambda: None, silent
        return self.last


def better_and_better(
    device: Device, scene: Scene, request: Request, coarse: bool, check: Callable[[], None], progress: Progress
) -> Iterator[Image]:
    """Draw a scene coarsely, then finer and finer; ``stats["refined"]`` tells scale and step, the last image is the best."""
    scene = resolve(scene, request.size_px)
    check_tones(scene)
    prepared, notes = annotated(scene, request.size_px)
    first = replace(request, tolerance=None)
    for scale, step in FIRST_PICTURES if coarse else ():
        keeps = request.keep_hits and scale == 1
        asked = replace(first, size_px=scaled(request.size_px, scale), step=step, keep_hits=keeps)
        image = noted(enlarged(draw(device, prepared, asked, check, progress), request.size_px), scene, notes)
        yield replace(image, stats=image.stats | {"refined": {"scale": scale, "step": step}})
    for image in levels(device, scene, request, check, progress):
        finest = min(image.stats["tolerance"]["pixels_by_step"])
        yield replace(image, stats=image.stats | {"refined": {"scale": 1.0, "step": finest}})
