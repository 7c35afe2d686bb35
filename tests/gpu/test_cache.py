"""What a device keeps: bounded by bytes, the least recent first, never what the current frame uses, nothing of what is gone."""

from __future__ import annotations

import gc
import threading
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import wgpu

import airlight as al
from airlight.gpu import compute
from airlight.gpu.cache import LEAST_BYTES, Cache, bytes_of, default_limit
from airlight.gpu.thread import RenderThread

TF = al.TransferFunction([(0, "black", 0), (1, "white", 1)])
SIZE = (8, 8)


class Owner:
    """Something that others refer to."""


class Held:
    """Something that says how many bytes it has."""

    def __init__(self, count: int) -> None:
        self.bytes = count - LEAST_BYTES


def in_frames(cache: Cache, *names: str, count: int = 1 << 20) -> None:
    """Ask for one thing a frame."""
    for name in names:
        cache.begin_frame()
        cache.get((name,), lambda: Held(count))


def names(cache: Cache) -> list[object]:
    return [key[0] for key in cache]


def test_the_least_recent_goes_first():
    cache = Cache(3 << 20)
    in_frames(cache, *"abcabd")
    assert names(cache) == ["a", "b", "d"]
    assert cache.bytes == 3 << 20
    in_frames(cache, "e", count=2 << 20)
    assert names(cache) == ["d", "e"]
    assert cache.bytes == 3 << 20


def test_what_the_frame_uses_stays_and_goes_after_it():
    cache = Cache(2 << 20)
    in_frames(cache, "old")
    cache.begin_frame()
    for name in "abcde":
        cache.get((name,), lambda: Held(1 << 20))
    assert names(cache) == list("abcde")
    cache.begin_frame()
    for name in "edcba":
        assert cache.find((name,)) is not None, "the next frame has all that it had"
    cache.trim()
    assert names(cache) == list("edcba")
    in_frames(cache, "f")
    assert names(cache) == ["a", "f"]


def test_things_without_size_are_bounded_too():
    cache = Cache(10 * LEAST_BYTES)
    for n in range(100):
        cache.begin_frame()
        cache.get((n,), lambda: "nothing much")
    assert len(names(cache)) == 10


def test_values_belong_to_the_very_owner():
    cache = Cache(1 << 30)
    first, second = Owner(), Owner()
    assert cache.get(("a",), lambda: "first", first) == "first"
    assert cache.get(("a",), lambda: "second", second) == "second"
    assert cache.get(("a",), lambda: "never", first) == "first"
    del first
    cache.forget_released()
    assert len(names(cache)) == 1
    assert cache.bytes == LEAST_BYTES


def test_a_number_that_comes_again_is_no_owner():
    """The number of an object is given to another one once it is gone, before anybody had time to tidy up."""
    cache = Cache(1 << 30)
    for n in range(200):
        owner = Owner()
        assert cache.get(("a",), lambda n=n: n, owner) == n
        del owner
    cache.forget_released()
    assert cache.bytes == 0


def test_one_of_several_owners_is_enough_to_go():
    cache = Cache(1 << 30)
    first, second = Owner(), Owner()
    cache.get(("a",), lambda: 1, first, second)
    del second
    cache.forget_released()
    assert names(cache) == []


def test_without_room_all_else_goes_and_it_is_tried_again():
    cache = Cache(1 << 30)
    in_frames(cache, "a", "b")
    cache.begin_frame()
    cache.find(("b",))

    def make() -> str:
        if "a" in names(cache):
            raise wgpu.GPUOutOfMemoryError("no room")
        return "made"

    assert cache.get(("c",), make) == "made"
    assert names(cache) == ["b", "c"]

    def never() -> None:
        raise wgpu.GPUOutOfMemoryError("no room")

    with pytest.raises(wgpu.GPUOutOfMemoryError):
        cache.get(("d",), never)


def test_owners_may_go_on_any_thread():
    """Another thread gives owners up while the render thread works: nothing breaks, and nothing is left."""
    cache, owners, told = Cache(1 << 30), [Owner() for _ in range(2000)], []
    cache.owner_released = lambda: told.append(threading.get_ident())
    for n, owner in enumerate(owners):
        cache.get(("a", n), lambda: 1, owner)
    del owner

    def give_up() -> None:
        while owners:
            owners.pop()

    other = threading.Thread(target=give_up)
    other.start()
    for _ in range(200):
        cache.begin_frame()
        cache.get(("b",), lambda: 1)
    other.join()
    cache.forget_released()
    assert names(cache) == ["b"]
    assert len(told) == 2000, "each rings once"


def test_the_render_thread_is_woken_and_does_the_work():
    did: list[int] = []
    done = threading.Event()

    def tidy() -> None:
        did.append(threading.get_ident())
        done.set()

    thread = RenderThread(idle=tidy)
    try:
        mine = thread.submit(lambda job: threading.get_ident()).result(10)
        done.clear()
        thread.wake()
        assert done.wait(10)
        assert set(did) == {mine}
    finally:
        thread.close()


def test_bytes_of_textures_and_buffers(renderer):
    renderer.warm_up()
    device = renderer._thread.submit(lambda job: renderer._open()).result()
    usage = wgpu.TextureUsage.TEXTURE_BINDING

    def texture(texel_format: str, levels: int = 1) -> int:
        made = device.gpu.create_texture(
            size=(8, 4, 2), dimension="3d", format=texel_format, usage=usage, mip_level_count=levels
        )
        return bytes_of(made)

    assert texture("r8uint") == 64
    assert texture("rg16float") == 64 * 4
    assert texture("rgba32float") == 64 * 16
    assert texture("r32float", levels=4) == 4 * (64 + 4 * 2 + 2 + 1)
    assert bytes_of(device.gpu.create_buffer(size=48, usage=wgpu.BufferUsage.COPY_DST)) == 48
    assert bytes_of(np.zeros((3, 5), np.float32)) == 60


def test_the_limit(monkeypatch):
    monkeypatch.delenv("AIRLIGHT_KEEP", raising=False)
    shared = default_limit("software", {"max-buffer-size": 1})
    assert shared > 1 << 28
    assert default_limit("discrete", {"max-buffer-size": 1 << 27}) == 1 << 27
    for text, count in (("512M", 512 << 20), ("1.5 GiB", 3 << 29), ("1000", 1000), ("0", 0)):
        monkeypatch.setenv("AIRLIGHT_KEEP", text)
        assert default_limit("discrete", {"max-buffer-size": 1}) == count
    monkeypatch.setenv("AIRLIGHT_KEEP", "much")
    with pytest.raises(al.ValueRangeError, match=r"AIRLIGHT_KEEP is 'much', must be a size: e.g. 4G or 500M"):
        default_limit("discrete", {"max-buffer-size": 1})


# -- in frames


def kept_grids(renderer: al.Renderer) -> int:
    return renderer._thread.submit(lambda job: sum(key[0] == "grid" for key in renderer._device.kept)).result()


@pytest.fixture
def small_renderer():
    with al.Renderer(keep_bytes=24 << 20) as made:
        yield made


def series(times: int = 20, channels: int = 1, side: int = 32) -> al.Volume:
    return al.Volume(np.random.default_rng(0).random((times, channels, side, side, side), dtype=np.float32))


def test_time_steps_do_not_pile_up(small_renderer):
    """40 steps of one MiB each; what is kept stays below 24 MiB, and pictures stay the same."""
    volume = series(40, side=64)
    first = [small_renderer.render(al.Scene(layers=[al.Layer(volume, TF, time=t)]), SIZE).rgba for t in range(40)]
    assert small_renderer.kept_bytes <= 24 << 20
    assert 1 <= kept_grids(small_renderer) < 24
    for t in (0, 39, 0):
        again = small_renderer.render(al.Scene(layers=[al.Layer(volume, TF, time=t)]), SIZE)
        assert np.array_equal(again.rgba, first[t])
        assert again.stats["kept"]["bytes"] <= again.stats["kept"]["limit"] == 24 << 20


def test_sets_of_channels_do_not_pile_up(small_renderer):
    volume = series(1, 6, 64)
    for first in range(6):
        for second in range(6):
            if first != second:
                channels = al.Channels((al.Channel(first, TF), al.Channel(second, TF)))
                small_renderer.render(al.Scene(layers=[al.Layer(volume, channels)]), SIZE)
    assert small_renderer.kept_bytes <= 24 << 20


def test_functions_do_not_pile_up(small_renderer):
    """Media at all voxels, one grid for each function: 4 MiB each."""
    volume = series(1, 1, 64)
    look = al.Look(field="preclassified", transfer="postclassified")
    for n in range(12):
        scene = al.Scene(volume, transfer=TF.scaled(1 + n), look=look)
        frame = small_renderer.render(scene, SIZE)
    assert small_renderer.kept_bytes <= 24 << 20
    assert np.array_equal(small_renderer.render(scene, SIZE).rgba, frame.rgba)


def test_a_frame_may_need_more_than_the_limit():
    volume = series(1, 1, 64)
    with al.Renderer(keep_bytes=0) as tight, al.Renderer() as roomy:
        uploads = []
        for _ in range(2):
            told = []
            frame = tight.render(al.Scene(volume, transfer=TF), SIZE, progress=lambda what, *_, t=told: t.append(what))
            uploads.append(told.count("upload"))
        assert uploads == [1, 0], "what a frame uses is there for the next one like it"
        assert np.array_equal(frame.rgba, roomy.render(al.Scene(volume, transfer=TF), SIZE).rgba)


@pytest.mark.parametrize("field", ["linear", "preclassified"])
def test_what_is_released_counts_to_nothing(small_renderer, field):
    """The render thread gives it up by itself: nobody asks it for anything."""
    look = al.Look(field=field, transfer="postclassified", gradient="precomputed")
    rest = []
    for _ in range(3):
        volume = series(1)
        small_renderer.render(al.Scene(volume, transfer=TF, look=look), SIZE)
        kept = small_renderer._device.kept
        assert "grid" in names(kept)
        del volume
        gc.collect()
        deadline = time.monotonic() + 10
        while "grid" in names(kept) and time.monotonic() < deadline:
            time.sleep(0.01)
        assert not {"grid", "classified", "gradients"} & set(names(kept))
        rest.append(kept.bytes)
    assert rest[0] == rest[1] == rest[2]


def test_keep_bytes_is_checked():
    with pytest.raises(al.ValueRangeError, match="keep_bytes is -1"):
        al.Renderer(keep_bytes=-1)


def test_of_a_kind_the_newest_are_kept():
    cache = Cache(1 << 30)
    for number in range(5):
        cache.begin_frame()
        cache.get(("table", number), lambda: np.zeros(4096, np.uint8))
        cache.get(("other", number), lambda: np.zeros(4096, np.uint8))
    cache.find(("table", 0))
    before = cache.bytes
    cache.keep_newest("table", 2)
    assert [key for key in cache if key[0] == "table"] == [("table", 4), ("table", 0)]
    assert len(list(cache)) == 7
    assert cache.bytes < before


def test_buffers_that_frames_need_now_and_then_stay():
    """What is given back and taken again leaves holes in the device's memory, which grows for ever where edits make tables."""
    made: list[int] = []

    def create_buffer(size: int, usage: int) -> SimpleNamespace:
        made.append(size)
        return SimpleNamespace(size=size, nbytes=size)

    device: Any = SimpleNamespace(kept=Cache(1 << 30), needed_at={}, gpu=SimpleNamespace(create_buffer=create_buffer))

    def held(asked: int) -> int:
        device.kept.begin_frame()
        return compute.buffer(device, "pixels", asked, 0).size

    held(160)
    for _ in range(compute.PATIENCE_FRAMES):
        assert held(160000) == held(160) == 160000
    assert made == [160, 160000]
    for _ in range(compute.PATIENCE_FRAMES - 1):
        assert held(160) == 160000
    assert held(160) == 160, "what nobody has needed for long goes"
    assert held(161) == 176
