"""Labels as numbers without gaps: any integers, up to 64 bits, become 0 to n - 1 once when a volume is first drawn.

Labels run in stretches along x, so that only the first voxel of each stretch is looked up.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DataError
from ..volume import AnyArray, Volume

CHUNK_VOXELS = 1 << 23
MOST_LOOKED_UP = 1 << 24  # range of labels up to which a list of all numbers in it beats a search
MOST_LABELS = 1 << 30

Numbers = npt.NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class LabelNumbers:
    """The distinct labels of a volume at a time step, in the order of their numbers: background first, then increasing.

    ``ids`` (n,) has the volume's type, or uint8 for bool; the background is among them even where no voxel has it.
    """

    volume: Volume
    time: int
    ids: AnyArray

    def of(self, labels: Any) -> npt.NDArray[np.int64]:
        """Numbers of labels (k,), -1 for those that do not occur."""
        try:
            wanted = np.array(list(labels), dtype=np.int64)
        except OverflowError:
            wanted = np.array(list(labels), dtype=object)
        info = np.iinfo(self.ids.dtype)
        most = min(info.max, np.iinfo(np.int64).max) if wanted.dtype == np.int64 else info.max
        fits = np.asarray((wanted >= info.min) & (wanted <= most), dtype=bool)
        ids = np.where(fits, wanted, self.ids[0]).astype(self.ids.dtype)
        others = self.ids[1:]
        found = np.full(len(ids), -1, dtype=np.int64)
        if len(others) and len(ids):
            place = np.minimum(np.searchsorted(others, ids), len(others) - 1)
            found = np.where(others[place] == ids, place + 1, -1)
        return np.where(fits, np.where(ids == self.ids[0], 0, found), -1)

    def slices(self) -> Iterator[tuple[int, Numbers]]:
        """Numbers of voxels, a few ``(z, y, x)`` slices at a time, with the first slice's place."""
        grid = _grid(self.volume, self.time)
        look_up = self._look_up()
        for z, part in _chunks(grid):
            starts, values = _stretches(part)
            if look_up is None:
                numbers = (np.searchsorted(self.ids[1:], values) + 1).astype(np.uint32)
                numbers[values == self.ids[0]] = 0
            else:
                numbers = look_up[_above(values, self._least)]
            lengths = np.diff(starts, append=part.size)
            yield z, np.repeat(numbers, lengths).reshape(part.shape)

    @property
    def _least(self) -> int:
        return int(min(self.ids[0], self.ids[min(1, len(self.ids) - 1)]))

    def _look_up(self) -> Numbers | None:
        """Number of each label from the least one on; None where there is too much between them."""
        width = int(max(self.ids[0], self.ids[-1])) - self._least + 1
        if width > MOST_LOOKED_UP:
            return None
        table = np.zeros(width, dtype=np.uint32)
        table[_above(self.ids, self._least)] = np.arange(len(self.ids), dtype=np.uint32)
        return table


def label_numbers(volume: Volume, time: int = 0, background: int = 0) -> LabelNumbers:
    """Distinct labels of a volume of integers at a time step; found once and kept with the volume.

    Raises
    ------
    DataError
        When the volume holds something else than integers, has several channels, or its labels are too many.
    """
    check_labels(volume)
    cache: dict[tuple[int, int], LabelNumbers] = volume.__dict__.setdefault("_label_numbers", {})
    if (time, background) not in cache:
        ids = _distinct(_grid(volume, time))
        if len(ids) > MOST_LABELS:
            raise DataError("labels", f"are {len(ids):,}, at most {MOST_LABELS:,} are told apart")
        info = np.iinfo(ids.dtype)
        if not info.min <= background <= info.max:
            raise DataError("labels.background", f"is {background}, which no {ids.dtype} is", "name a label of this type")
        first = ids.dtype.type(background)
        ids = np.concatenate([[first], ids[ids != first]]).astype(ids.dtype)
        ids.flags.writeable = False
        cache[time, background] = LabelNumbers(volume, time, ids)
    return cache[time, background]


def check_labels(volume: Volume) -> None:
    """Refuse volumes that hold something else than integers, or several channels."""
    if volume.dtype.kind not in "iub":
        remedy = "labels are integers: al.Volume(volume.array.astype('int32'), world_from_index=volume.world_from_index)"
        raise DataError("labels", f"are {volume.dtype}", remedy)
    if volume.channel_count > 1:
        raise DataError(
            "labels", f"have {volume.channel_count} channels", "make a volume of one: al.Volume(volume.grid(0), ...)"
        )


def _grid(volume: Volume, time: int) -> AnyArray:
    grid = volume.grid(0, time)
    return grid.view(np.uint8) if grid.dtype.kind == "b" else grid


def _chunks(grid: AnyArray) -> Iterator[tuple[int, AnyArray]]:
    depth = max(1, CHUNK_VOXELS // max(1, grid[0].size))
    for z in range(0, len(grid), depth):
        yield z, np.ascontiguousarray(grid[z : z + depth])


def _stretches(part: AnyArray) -> tuple[npt.NDArray[np.int64], AnyArray]:
    """Where stretches of equal labels begin in the flat array, and their labels."""
    flat = part.reshape(-1)
    starts = np.concatenate([[0], np.flatnonzero(flat[1:] != flat[:-1]) + 1])
    return starts, flat[starts]


def _distinct(grid: AnyArray) -> AnyArray:
    found = np.empty(0, dtype=grid.dtype)
    for _, part in _chunks(grid):
        found = np.union1d(found, _stretches(part)[1])
    return found


def _above(ids: AnyArray, least: int) -> npt.NDArray[np.int64]:
    """Labels less the least one; unsigned 64-bit numbers wrap round to the right difference."""
    bits = ids.astype(np.int64 if ids.dtype.kind == "i" else np.uint64).view(np.uint64)
    return (bits - np.uint64(least % (1 << 64))).astype(np.int64)
