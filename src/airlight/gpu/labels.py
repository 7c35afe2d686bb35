"""Labels as textures of whole numbers, in the narrowest format that holds their count."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import wgpu

from ..errors import LimitError
from ..labels import LabelNumbers
from .device import Device
from .textures import Encoding, Progress, VolumeTexture

Numbers = npt.NDArray[np.uint32]


def upload_labels(device: Device, labels: LabelNumbers, progress: Progress) -> VolumeTexture:
    """Put labels into a 3-D texture: twice the label's number, plus one where neighbours differ; see ``LabelCells``.

    Raises
    ------
    LimitError
        When the volume, with a voxel of background all round, is larger than the device's textures.
    """
    width, height, depth = (n + 2 for n in labels.volume.size)
    most = device.limits["max-texture-dimension-3d"]
    if max(width, height, depth) > most:
        x, y, z = labels.volume.size
        raise LimitError(
            "labels",
            f"have {x} x {y} x {z} voxels; {device.info.name} holds at most {most - 2} a side",
            "crop or downsample them",
        )
    bits = next(bits for bits in (8, 16, 32) if 2 * len(labels.ids) <= 1 << bits)
    encoding = Encoding(f"r{bits}uint", f"u{bits // 8}", 1.0, 0.0)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.gpu.create_texture(size=(width, height, depth), dimension="3d", format=encoding.format, usage=usage)
    row = width * bits // 8
    for z, cells in label_cells(labels):
        device.queue.write_texture(
            {"texture": texture, "origin": (0, 0, z)},
            np.ascontiguousarray(cells.astype(encoding.dtype)),
            {"bytes_per_row": row, "rows_per_image": height},
            (width, height, len(cells)),
        )
        progress("upload labels", z + len(cells), depth)
    return VolumeTexture(texture, (encoding,), row * height * depth)


def label_cells(labels: LabelNumbers) -> Iterator[tuple[int, Numbers]]:
    """Texels a few slices at a time, with the first slice's place; one voxel of background lies round all."""
    x, y, _ = labels.volume.size
    below = np.zeros((1, y + 2, x + 2), dtype=np.uint32)
    z = 0
    for _, part in labels.slices():
        numbers = np.concatenate([below, np.pad(part, ((0, 0), (1, 1), (1, 1)))])
        yield z, 2 * numbers[:-1] + _is_mixed(numbers)[:-1]
        z += len(part)
        below = numbers[-1:]
    yield z, 2 * below + _is_mixed(np.concatenate([below, np.zeros_like(below)]))[:1]
    yield z + 1, np.zeros_like(below)


def _is_mixed(numbers: Numbers) -> npt.NDArray[np.bool_]:
    """Whether a voxel and its seven neighbours upwards differ; not known, and False, for the last of each axis."""
    mixed = np.zeros(numbers.shape, dtype=bool)
    along_x = numbers[:, :, 1:] != numbers[:, :, :-1]
    in_plane = along_x[:, 1:] | along_x[:, :-1] | (numbers[:, 1:, :-1] != numbers[:, :-1, :-1])
    mixed[:-1, :-1, :-1] = in_plane[1:] | in_plane[:-1] | (numbers[1:, :-1, :-1] != numbers[:-1, :-1, :-1])
    return mixed
