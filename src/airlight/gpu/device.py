"""Adapters and devices: which one is taken, with which limits and features."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import wgpu
from wgpu.backends.wgpu_native.extras import set_instance_extras

from ..errors import DeviceError
from ..shader.program import Traits
from .cache import Cache, default_limit
from .quick_types import parse_types_quickly

KINDS = {"DiscreteGPU": "discrete", "IntegratedGPU": "integrated", "CPU": "software"}
PREFERENCE = ("discrete", "integrated", "other", "software")
FEATURES = ("float32-filterable", "float32-blendable", "texture-format16bit-norm")
# Limits that every WebGPU device has (W3C WebGPU, section 3.6.2).
CORE_LIMITS = {
    "max-texture-dimension-1d": 8192,
    "max-texture-dimension-2d": 8192,
    "max-texture-dimension-3d": 2048,
    "max-texture-array-layers": 256,
    "max-bind-groups": 4,
    "max-bindings-per-bind-group": 1000,
    "max-dynamic-uniform-buffers-per-pipeline-layout": 8,
    "max-dynamic-storage-buffers-per-pipeline-layout": 4,
    "max-sampled-textures-per-shader-stage": 16,
    "max-samplers-per-shader-stage": 16,
    "max-storage-buffers-per-shader-stage": 8,
    "max-storage-textures-per-shader-stage": 4,
    "max-uniform-buffers-per-shader-stage": 12,
    "max-uniform-buffer-binding-size": 65536,
    "max-storage-buffer-binding-size": 128 << 20,
    "max-buffer-size": 256 << 20,
    "max-compute-workgroup-storage-size": 16384,
    "max-compute-invocations-per-workgroup": 256,
    "max-compute-workgroup-size-x": 256,
    "max-compute-workgroup-size-y": 256,
    "max-compute-workgroup-size-z": 64,
    "max-compute-workgroups-per-dimension": 65535,
}
NO_ADAPTER = "install a driver; on Debian and Ubuntu without a GPU: apt-get install mesa-vulkan-drivers libvulkan1"


@dataclass(frozen=True)
class DeviceInfo:
    """An adapter, as users see it; ``kind`` is discrete, integrated, software or other."""

    number: int
    name: str
    kind: str
    backend: str
    driver: str
    chosen: bool = False


class Device:
    """An opened device with what follows from its adapter. Owned and used by the render thread alone.

    Attributes
    ----------
    needed_at
        The last frame that needed most of a buffer, by the buffer's name.
    """

    def __init__(self, adapter: Any, info: DeviceInfo, core: bool, keep_bytes: int | None = None) -> None:
        self.info = info
        features = [] if core else [f for f in FEATURES if f in adapter.features]
        limits = CORE_LIMITS if core else {k: v for k, v in adapter.limits.items() if k.startswith(("max-", "min-"))}
        try:
            self.gpu: Any = adapter.request_device_sync(required_features=features, required_limits=limits)
        except Exception as error:
            raise DeviceError(
                f"device {info.name!r}", f"could not be opened ({error})", "try another one: airlight devices"
            ) from error
        self.features = frozenset(features)
        self.core = core
        self.kept = Cache(default_limit(info.kind, adapter.limits) if keep_bytes is None else keep_bytes)
        self.needed_at: dict[Hashable, int] = {}

    @property
    def limits(self) -> dict[str, int]:
        """Limits of the device, by WebGPU's names."""
        return dict(self.gpu.limits)

    @cached_property
    def traits(self) -> Traits:
        """What decides which program is linked. Rows of pixels in a workgroup are twice as fast as squares on CPUs."""
        software = self.info.kind == "software"
        return Traits("float32-filterable" in self.features, (16, 1) if software else (8, 8), holds_uniforms=software)

    @cached_property
    def strands(self) -> int:
        """Into how many sets of rows, dealt out in turn, dispatches are cut: software gives each processor one stretch."""
        return (os.cpu_count() or 1) if self.info.kind == "software" else 1

    @property
    def queue(self) -> Any:
        """The device's queue."""
        return self.gpu.queue

    def wait(self) -> None:
        """Wait until all submitted work is done.

        By reading a few bytes back: ``on_submitted_work_done`` of wgpu-py 0.32 raises a TypeError for its callback's type.
        """
        usage = wgpu.BufferUsage.COPY_SRC | wgpu.BufferUsage.COPY_DST
        read = self.kept.get(("wait",), lambda: self.gpu.create_buffer(size=16, usage=usage))
        self.queue.read_buffer(read, 0, 4)

    def close(self) -> None:
        """Release everything at once."""
        self.kept.clear()
        self.gpu.destroy()


def prepare_environment() -> None:
    """Give Mesa the private runtime folder that it asks for, where there is none."""
    if sys.platform.startswith("linux") and not os.environ.get("XDG_RUNTIME_DIR"):
        folder = os.path.join(tempfile.gettempdir(), f"airlight-runtime-{os.getuid()}")
        os.makedirs(folder, mode=0o700, exist_ok=True)
        os.environ["XDG_RUNTIME_DIR"] = folder


@lru_cache(maxsize=1)
def adapters() -> tuple[tuple[Any, DeviceInfo], ...]:
    """All adapters in wgpu's order. On Linux with Vulkan alone, which starts three times as fast."""
    prepare_environment()
    parse_types_quickly()
    if sys.platform.startswith("linux"):
        # What uses wgpu beside airlight may have chosen already.
        with contextlib.suppress(RuntimeError):
            set_instance_extras(backends=["Vulkan"])
    found = list(wgpu.gpu.enumerate_adapters_sync())
    result = []
    for number, adapter in enumerate(found):
        i = adapter.info
        kind = KINDS.get(i["adapter_type"], "other")
        result.append((adapter, DeviceInfo(number, i["device"], kind, i["backend_type"], i["description"])))
    return tuple(result)


def choose(wanted: str | None = None) -> tuple[Any, DeviceInfo]:
    """Adapter that a user asked for, by number, kind or part of its name; otherwise the one that is most likely fast.

    Raises
    ------
    DeviceError
        When there is none, or none that fits.
    """
    wanted = wanted or os.environ.get("AIRLIGHT_DEVICE") or ""
    known = adapters()
    if not known:
        raise DeviceError("device", "none answers: no adapter speaks Vulkan, Metal or Direct3D 12", NO_ADAPTER)
    if wanted.isdigit():
        fitting = [pair for pair in known if pair[1].number == int(wanted)]
    else:
        fitting = [pair for pair in known if wanted in ("", pair[1].kind)]
        fitting = fitting or [pair for pair in known if wanted.lower() in pair[1].name.lower()]
    if not fitting:
        names = ", ".join(f"{info.number}: {info.name} ({info.kind})" for _, info in known)
        raise DeviceError("device", f"{wanted!r} is not there", f"choose one of {names}")
    return min(fitting, key=lambda pair: PREFERENCE.index(pair[1].kind))


def devices(wanted: str | None = None) -> list[DeviceInfo]:
    """Adapters of this machine; the one that would be used is marked as chosen."""
    from dataclasses import replace

    if not adapters():
        return []
    taken = choose(wanted)[1]
    return [replace(info, chosen=info == taken) for _, info in adapters()]


def open_device(wanted: str | None = None, keep_bytes: int | None = None) -> Device:
    """Open the adapter that ``choose`` picks. ``AIRLIGHT_CORE=1`` keeps to core WebGPU's limits, without features.

    ``keep_bytes`` bounds what is kept from frame to frame; None leaves it to ``AIRLIGHT_KEEP`` and the adapter.
    """
    adapter, info = choose(wanted)
    return Device(adapter, info, core=os.environ.get("AIRLIGHT_CORE", "") not in ("", "0"), keep_bytes=keep_bytes)
