"""What every reader is told, and the table of readers: one module a format family, thin over a well-kept library."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..errors import LimitError

Progress = Callable[[str, int, int], None]
"""Called with what is done, how much of it is done, and how much there is (0 when unknown)."""


def _silent(_what: str, _done: int, _total: int) -> None:
    pass


@dataclass(frozen=True)
class ReadOptions:
    """Choices and limits of one reading.

    ``dataset`` names an array inside the file, ``level`` a level of a pyramid (0 is the finest). ``shape_xyz``, ``dtype``,
    ``spacing``, ``offset_bytes`` and ``big_endian`` describe a raw file. ``max_bytes`` bounds what one file may inflate to.
    """

    dataset: str = ""
    level: int = 0
    shape_xyz: tuple[int, ...] | None = None
    dtype: str = ""
    spacing: tuple[float, float, float] | None = None
    offset_bytes: int = 0
    big_endian: bool = False
    max_bytes: int = 8 << 30
    progress: Progress = _silent

    def check_bytes(self, where: str, needed: int) -> None:
        """Refuse what would take more memory than allowed, before anything is allocated."""
        if needed > self.max_bytes:
            raise LimitError(
                where,
                f"declares {needed / 2**20:,.0f} MiB, the limit is {self.max_bytes / 2**20:,.0f} MiB",
                "raise --max-memory (max_memory=) or choose a coarser level or a smaller file",
            )
