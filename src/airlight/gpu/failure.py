"""Failures of the device, as errors that tell the way out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import wgpu

from ..errors import AirlightError, DeviceError, LimitError
from .device import DeviceInfo
from .thread import Cancelled


@contextmanager
def device_failures(info: DeviceInfo, drop: Callable[[], None]) -> Iterator[None]:
    """Turn what the device raises into errors of the package; ``drop`` makes room for a new device.

    Raises
    ------
    LimitError
        When the device ran out of memory.
    DeviceError
        When it was lost or refused what it was told.
    """
    where = f"device {info.name!r}"
    try:
        yield
    except (AirlightError, Cancelled, RecursionError, NotImplementedError):
        raise
    except (wgpu.GPUOutOfMemoryError, MemoryError) as error:
        drop()
        remedy = "draw a smaller image, a coarser level or a cropped volume, or choose another device"
        raise LimitError(where, "ran out of memory", remedy) from error
    except (wgpu.GPUError, RuntimeError) as error:
        drop()
        raise DeviceError(where, f"was lost or failed ({error})", "render again: a new device is opened") from error
