"""``airlight devices``: the adapters that can render."""

from __future__ import annotations

from ..errors import DeviceError


def devices() -> int:
    """List the adapters that can render; the star marks the one that is taken.

    --device and AIRLIGHT_DEVICE choose another, by a part of its name or kind. AIRLIGHT_CORE=1 keeps to core WebGPU.
    """
    from .. import api

    found = api.devices()
    if not found:
        raise DeviceError(
            "no adapter",
            "answers",
            "install a driver; without a GPU, on Debian and Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1",
        )
    rows = [("*" if d.chosen else " ", d.name, d.kind, d.backend, d.driver) for d in found]
    widths = [max(len(row[n]) for row in rows) for n in range(4)]
    for row in rows:
        print(" ".join([*(text.ljust(width) for text, width in zip(row, widths, strict=False)), row[4]]).rstrip())
    return 0
