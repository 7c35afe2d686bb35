"""Devices: choice, limits, loss, memory; each failure is a clear error, and the next frame works again."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
import wgpu

import airlight as al
from airlight.gpu import device as devices
from airlight.gpu import textures
from airlight.gpu.device import DeviceInfo
from airlight.gpu.thread import Cancelled

TF = al.TransferFunction([(0, "black", 0), (1, "white", 1)])


@pytest.fixture
def own_renderer():
    with al.Renderer() as made:
        yield made


def small(seed: int = 0) -> al.Scene:
    rng = np.random.default_rng(seed)
    return al.Scene(al.Volume(rng.random((8, 8, 8), dtype=np.float32)), transfer=TF)


def fake(*kinds: str):
    return tuple((object(), DeviceInfo(i, f"Maker {k} {i}", k, "Vulkan", "1.0")) for i, k in enumerate(kinds))


def test_the_fastest_kind_is_taken_first(monkeypatch):
    monkeypatch.delenv("AIRLIGHT_DEVICE", raising=False)
    monkeypatch.setattr(devices, "adapters", lambda: fake("software", "integrated", "discrete"))
    assert devices.choose()[1].kind == "discrete"
    assert devices.choose("software")[1].number == 0
    assert devices.choose("1")[1].kind == "integrated"
    assert devices.choose("maker disc")[1].kind == "discrete"
    monkeypatch.setenv("AIRLIGHT_DEVICE", "integrated")
    assert devices.choose()[1].kind == "integrated"
    assert [info.chosen for info in devices.devices()] == [False, True, False]


def test_a_device_that_is_not_there_names_those_that_are(monkeypatch):
    monkeypatch.setattr(devices, "adapters", lambda: fake("software"))
    with pytest.raises(al.DeviceError, match=r"'nvidia' is not there: choose one of 0: Maker software 0 \(software\)"):
        devices.choose("nvidia")


def test_no_adapter_says_what_to_install(monkeypatch):
    monkeypatch.setattr(devices, "adapters", lambda: ())
    monkeypatch.delenv("AIRLIGHT_DEVICE", raising=False)
    with pytest.raises(al.DeviceError, match="apt-get install mesa-vulkan-drivers"):
        devices.choose()
    assert devices.devices() == []


def test_device_loss_is_an_error_and_the_next_frame_works(own_renderer):
    before = own_renderer.render(small(), (16, 16)).rgba
    own_renderer._device.gpu.destroy()
    with pytest.raises(al.DeviceError, match="was lost or failed"):
        own_renderer.render(small(), (16, 16))
    assert np.array_equal(own_renderer.render(small(), (16, 16)).rgba, before)


def test_out_of_memory_is_an_error_and_the_next_frame_works(own_renderer, monkeypatch):
    before = own_renderer.render(small(), (16, 16)).rgba

    def full(*_args, **_kwargs):
        raise wgpu.GPUOutOfMemoryError("no room")

    with monkeypatch.context() as patched:
        patched.setattr(textures, "upload_grid", full)
        with pytest.raises(al.LimitError, match="ran out of memory: draw a smaller image"):
            own_renderer.render(small(1), (16, 16))
    assert np.array_equal(own_renderer.render(small(), (16, 16)).rgba, before)


def test_a_volume_beyond_the_limits_is_refused_before_upload(own_renderer):
    long = al.Volume(np.zeros((1, 1, 5000), dtype=np.uint8))
    with pytest.raises(al.LimitError, match=r"5000 x 1 x 1 voxels; .* holds at most 4096 a side"):
        own_renderer.render(al.Scene(long, transfer=TF), (8, 8))


def test_core_device_has_core_limits(core_renderer):
    device = core_renderer._device
    assert device.core
    assert device.limits["max-storage-buffers-per-shader-stage"] == 8
    assert device.limits["max-texture-dimension-3d"] == 2048
    assert not device.features


def test_an_image_beyond_one_binding_is_drawn_in_bands(own_renderer, monkeypatch):
    """The same picture, whatever part of it fits into a binding."""
    scene = small()
    whole = own_renderer.render(scene, (40, 30))
    few = own_renderer._device.limits | {"max-storage-buffer-binding-size": 40 * 16 * 7}
    monkeypatch.setattr(type(own_renderer._device), "limits", few)
    for tone in ("linear", "reinhard"):
        parts = own_renderer.render(al.Scene(scene.layers[0].volume, transfer=TF, look=al.Look(tone=tone)), (40, 30))
        if tone == "linear":
            assert np.array_equal(parts.rgba, whole.rgba)
            assert np.array_equal(parts.depth, whole.depth)
        else:
            banded = parts.rgba
    monkeypatch.undo()
    plain = own_renderer.render(al.Scene(scene.layers[0].volume, transfer=TF, look=al.Look(tone="reinhard")), (40, 30))
    assert np.abs(plain.rgba - banded).max() < 1e-5


def test_volumes_and_tables_leave_the_device_with_their_owners(own_renderer):
    """No texture is left of a volume that nobody holds; the same volume is uploaded once."""
    own_renderer.render(small(), (8, 8))
    device = own_renderer._device

    def grids() -> int:
        gc.collect()
        own_renderer.kept_bytes  # noqa: B018 - whoever asks learns of what is there, and of nothing that is gone
        return sum(key[0] == "grid" for key in device.kept)

    base = grids()
    for seed in range(5):
        scene = small(seed)
        first = own_renderer.render(scene, (8, 8))
        own_renderer.render(scene, (8, 8))
        assert grids() == base + 1
        del scene, first
    assert grids() == base


def test_uploads_come_in_chunks_with_progress(own_renderer, monkeypatch):
    monkeypatch.setattr(textures, "CHUNK_BYTES", 8 * 8 * 2 * 4)
    told = []
    own_renderer.render(small(9), (8, 8), progress=lambda *what: told.append(what))
    assert [t for t in told if t[0] == "upload"] == [("upload", z, 8) for z in (2, 4, 6, 8)]
    assert told[-1] == ("render", 64, 64)


def test_mesa_gets_a_private_folder_and_says_nothing():
    """Without XDG_RUNTIME_DIR Mesa would print an error line."""
    env = {k: v for k, v in os.environ.items() if k != "XDG_RUNTIME_DIR"}
    code = "import airlight as al; al.devices()"
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, timeout=120, check=True)
    assert done.stderr == ""


def test_importing_the_package_is_light():
    """Neither the device nor a reader nor a server is imported, and it takes at most 0.3 s (measured in the benchmark)."""
    heavy = ("wgpu", "PIL", "nibabel", "nrrd", "pydicom", "tifffile", "rich")
    code = f"import sys, airlight; print(*[m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.strip() == ""


def test_a_newer_frame_of_a_view_ends_the_older_between_tiles(own_renderer):
    """The old frame would take minutes; it is given up at the next tile."""
    volume = al.Volume(np.random.default_rng(0).random((48, 48, 48), dtype=np.float32))
    scene = al.Scene(volume, transfer=TF.scaled(1e-3), look=al.Look(shade="none"))
    tiles = threading.Event()
    old = own_renderer.submit(
        scene, (2000, 2000), step=0.002, view="a", progress=lambda what, *_: tiles.set() if what == "render" else None
    )
    assert tiles.wait(60)
    new = own_renderer.submit(scene, (8, 8), view="a")
    assert new.result(60).rgba.shape == (8, 8, 4)
    with pytest.raises(Cancelled):
        old.result(1)


def test_closing_a_renderer_twice_is_fine():
    made = al.Renderer()
    made.render(small(), (4, 4))
    made.close()
    made.close()
    with pytest.raises(al.DeviceError, match="renderer is closed"):
        made.render(small(), (4, 4))
