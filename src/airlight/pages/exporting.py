"""``airlight.export``: a scene, a volume or a file to one page."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import api
from ..errors import FileError, ValueRangeError
from ..files import write_text
from ..first_picture import resolve
from ..stage import Stage, make_stage
from ..transfer.given import check_size
from ..volume import Volume

if TYPE_CHECKING:
    from ..gpu.textures import Progress

ENDINGS = (".html", ".htm")
SIZE = (768, 768)
VOXELS = 128
MOST_TITLE = 200
STILL_QUALITY = 88


@dataclass(frozen=True)
class Exported:
    """What was written: ``bytes`` in all, voxels of the page and of the volume, bits of a voxel and what they cost at most."""

    path: Path
    bytes: int
    size: tuple[int, int, int]
    original_size: tuple[int, int, int]
    bits: int
    error: float
    value_unit: str
    is_editable: bool

    @property
    def notes(self) -> Iterator[str]:
        """Tell what the page shows otherwise than the volume is."""
        if self.size != self.original_size:
            yield f"the page holds {_times(self.size)} voxels, means of the volume's {_times(self.original_size)}"
        if self.error:
            yield f"values are stored in {self.bits} bits, to within {_number(self.error)} {self.value_unit}".rstrip()
        if not self.is_editable:
            yield "the page draws this look as it is: it edits transfer functions of one value made of points"


def export(
    what: Any,
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] = SIZE,
    voxels: int | None = VOXELS,
    bits: int | None = None,
    title: str = "",
    driver: str | Stage = "march",
    step: float = 1.0,
    device: str | int | None = None,
    progress: Progress | None = None,
) -> Exported:
    """Write a page that draws a volume in any browser with WebGPU: to be turned, and its transfer function edited.

    The file holds the volume, the WGSL programs of the look, and a still picture for browsers without WebGPU. Nothing else of
    the volume's file goes into it: no name, no path, no header.

    Parameters
    ----------
    what
        A scene, a volume or a file, as for ``airlight.render``.
    path
        A file ending in ``.html``; it appears whole or not at all.
    size
        Width and height of the still picture in pixels. What it shows, the page shows in a window of any shape.
    voxels
        Most voxels along an axis, in [2, 512]; larger volumes are averaged over boxes. None keeps all of up to 512.
    bits
        8 or 16 of a stored value; None takes 8 where they hold all values, else 16.
    title
        Heading of the page.
    driver, step
        As for ``airlight.render``; the page marches.
    device
        Adapter that draws the still picture.
    progress
        Called with what is done, how much of it, and how much there is.

    Returns
    -------
    Exported
        What was written; ``.notes`` tell what down-sampling and bits changed.

    Raises
    ------
    AirlightError
        Before anything is written, for looks that a page cannot draw, data that it cannot hold, and wrong parameters.

    Examples
    --------
    >>> import airlight as al
    >>> al.export("head.nii.gz", "head.html", title="Head")          # doctest: +SKIP
    """
    from .carried import carried, check_scene_for_page
    from .page import page_text
    from .stored import store

    target = checked_target(path)
    check_size(size)
    if not isinstance(title, str) or len(title) > MOST_TITLE:
        raise ValueRangeError("title", f"must be a text of at most {MOST_TITLE} letters")
    chosen, tell = make_stage("driver", driver), progress or (lambda *_: None)
    scene = resolve(api.as_scene(what, size, progress), size)
    check_scene_for_page(scene)
    layer = scene.visible_layers[0]
    stored = store(layer, voxels, bits, tell)
    shown = replace(scene, layers=(replace(layer, volume=stored.volume, channel=0, time=0),))
    page = carried(shown, stored, size, chosen, step)
    image = api.render(shown, size, driver=chosen, step=step, device=device, progress=progress)
    told = Exported(
        target,
        0,
        stored.volume.size,
        layer.volume.size,
        stored.bits,
        stored.error,
        layer.volume.value_unit,
        page.is_editable,
    )
    tell("pack", 0, 1)
    text = page_text(title, caption_of(told, stored.volume), page.plain, stored.packed(), _still(image.picture()))
    write_text(target, text)
    tell("pack", 1, 1)
    return replace(told, bytes=len(text.encode()))


def checked_target(path: str | os.PathLike[str]) -> Path:
    """Return where a page goes.

    Raises
    ------
    FileError
        For other endings, folders, and folders that are not there.
    """
    target = Path(path)
    if target.suffix.lower() not in ENDINGS:
        raise FileError(str(target), "is no name of a page", f"let it end in {ENDINGS[0]}")
    if target.is_dir():
        raise FileError(str(target), "is a folder", "name a file in it")
    if not target.absolute().parent.is_dir():
        raise FileError(str(target), "cannot be written, its folder is not there", f"make {target.parent}")
    return target


def caption_of(told: Exported, volume: Volume) -> str:
    """Return what stands under the picture: voxels, their size and unit, and what storing them cost."""
    spacing = " x ".join(f"{width:.3g}" for width in volume.spacing)
    parts = [f"{_times(told.size)} voxels of {spacing} {volume.units}".rstrip()]
    if told.size != told.original_size:
        parts.append(f"averaged from {_times(told.original_size)}")
    parts.append(f"values in {told.bits} bits" + (f", to within {_number(told.error)} {told.value_unit}" if told.error else ""))
    return "; ".join(part.rstrip() for part in parts)


def _still(picture: np.ndarray[Any, Any]) -> bytes:
    """JPEG of a picture; what is transparent lies over black."""
    from PIL import Image as Pillow

    if picture.shape[2] == 4:
        alpha = picture[..., 3:].astype(np.float32) / 255
        picture = np.rint(picture[..., :3] * alpha).astype(np.uint8)
    out = io.BytesIO()
    Pillow.fromarray(picture).save(out, "jpeg", quality=STILL_QUALITY, subsampling=0)
    return out.getvalue()


def _times(size: tuple[int, int, int]) -> str:
    return " x ".join(map(str, size))


def _number(value: float) -> str:
    digits = 2 - math.floor(math.log10(abs(value))) - 1
    return f"{round(value, digits):g}"
