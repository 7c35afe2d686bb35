"""`open` itself: how a file's kind is told, what is refused, what every error says, and reading in a process of its own."""

from __future__ import annotations

import gzip
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import nibabel
import numpy as np
import pytest

from airlight import io
from airlight.errors import AirlightError, DataError, FileError, LimitError, MissingExtraError
from airlight.io import formats, untrusted
from airlight.io.options import ReadOptions
from airlight.volume import Volume

LIGHT = ("nrrd", "nifti", "metaimage", "npy", "raw", "vti", "mrc")
SUFFIXES = (".nrrd", ".nii", ".nii.gz", ".npy")


def saved(folder: Path, suffix: str, array: np.ndarray) -> Path:
    path = folder / f"a{suffix}"
    io.save(Volume(array, spacing=(1, 2, 3), units="mm", anatomical=True), path)
    return path


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", ["nameless", "a.unknown", "A.DAT", "a.raw", "a.img"])
def test_first_bytes_decide_where_the_name_does_not(tmp_path: Path, ramp: np.ndarray, suffix: str, name: str) -> None:
    path = saved(tmp_path, suffix, ramp).rename(tmp_path / name)
    np.testing.assert_array_equal(io.open(path).array, ramp)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_name_that_lies_is_told(tmp_path: Path, ramp: np.ndarray, suffix: str) -> None:
    path = saved(tmp_path, suffix, ramp).rename(tmp_path / "a.mha")
    with pytest.raises(FileError, match=r"is named \.mha and holds .*rename it so that it ends in \."):
        io.open(path)


@pytest.mark.parametrize("suffix", [e for family in formats.FAMILIES.values() for e in family.extensions])
@pytest.mark.parametrize("content", [b"", b"\0", b"rubbish " * 200, b"\x1f\x8b" + b"rubbish" * 9])
def test_every_extension_refuses_rubbish(tmp_path: Path, suffix: str, content: bytes) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"a\.") as caught:
        io.open(path)
    assert str(path) in str(caught.value)
    assert caught.value.remedy or io.formats.EXTENSIONS[suffix] not in LIGHT
    assert "\n" not in str(caught.value)


def test_upper_case_extensions(tmp_path: Path, ramp: np.ndarray) -> None:
    path = saved(tmp_path, ".nrrd", ramp).rename(tmp_path / "A.NRRD")
    np.testing.assert_array_equal(io.open(str(path)).array, ramp)


def test_missing_folders_and_pipes_are_told(tmp_path: Path, ramp: np.ndarray) -> None:
    with pytest.raises(FileError, match="does not exist"):
        io.open(tmp_path / "absent.nrrd")
    with pytest.raises(FileError, match="no OME-Zarr"):
        io.open(tmp_path)
    saved(tmp_path, ".nii", ramp)
    with pytest.raises(FileError, match=r"name one of its files, e\.g\. a\.nii"):
        io.open(tmp_path)
    os.mkfifo(tmp_path / "pipe.nrrd")
    with pytest.raises(FileError, match="no plain file"):
        io.open(tmp_path / "pipe.nrrd")
    with pytest.raises(FileError):
        io.open("a\0b.nrrd")
    with pytest.raises(FileError):
        io.open(tmp_path / ("a" * 5000))


def test_more_than_the_limit_is_refused_before_it_is_read(tmp_path: Path, ramp: np.ndarray) -> None:
    for suffix in SUFFIXES:
        with pytest.raises(LimitError, match="max-memory"):
            io.open(saved(tmp_path, suffix, ramp), max_memory=100)


def test_a_bomb_is_refused(tmp_path: Path) -> None:
    bomb = gzip.compress(bytes(1 << 24))
    head = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: {0} 1024 1024\nencoding: gzip\n\n"
    path = tmp_path / "a.nrrd"
    path.write_bytes(head.format(4096).encode() + bomb)
    with pytest.raises(FileError, match="more than"):
        io.open(path)
    path.write_bytes(head.format(8).encode() + bomb)
    with pytest.raises(FileError, match="more samples"):
        io.open(path)


def test_many_tiny_members_do_not_hang(tmp_path: Path) -> None:
    path = tmp_path / "a.nrrd"
    head = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 64 64 64\nencoding: gzip\n\n"
    path.write_bytes(head + gzip.compress(b"") * 50_000)
    start = time.perf_counter()
    with pytest.raises(FileError, match="cut short"):
        io.open(path)
    assert time.perf_counter() - start < 5


def test_an_absent_package_is_named_with_its_cure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(2000))
    monkeypatch.setitem(sys.modules, "h5py", None)
    monkeypatch.delitem(sys.modules, "airlight.io.hdf5", raising=False)
    with pytest.raises(MissingExtraError, match=r'pip install "airlight\[hdf5\]"'):
        io.open(path)


def test_what_a_library_raises_keeps_its_cause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ramp: np.ndarray) -> None:
    path = saved(tmp_path, ".npy", ramp)
    for raised, expected in (
        (ZeroDivisionError("oops"), FileError),
        (MemoryError(), LimitError),
        (RecursionError(), FileError),
    ):

        def fail(*_args: object, _raised: BaseException = raised) -> None:
            raise _raised

        monkeypatch.setattr("airlight.io.npy.read", fail)
        with pytest.raises(expected) as caught:
            io.open(path)
        assert caught.value.__cause__ is raised


def test_progress_is_reported(tmp_path: Path, ramp: np.ndarray) -> None:
    calls: list[tuple[str, int, int]] = []
    io.open(saved(tmp_path, ".nrrd", ramp), progress=lambda *call: calls.append(call))
    assert calls[-1] == ("reading a.nrrd", 120, 120)


@pytest.mark.data
def test_a_small_volume_opens_fast(data_dir: Path) -> None:
    code = (
        "import time; start = time.perf_counter(); from airlight import io; "
        f"io.open({str(data_dir / 'ct_head.nrrd')!r}); print(time.perf_counter() - start); "
        "import sys; assert 'nibabel' not in sys.modules and 'SimpleITK' not in sys.modules"
    )
    run = [sys.executable, "-c", code]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(part for part in sys.path if part)}
    best = min(float(subprocess.run(run, check=True, capture_output=True, env=environment).stdout) for _ in range(3))
    assert best < 1.0  # measured: 0.2 s with NumPy's import, on an idle machine


# -- reading in a process of its own


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_untrusted_files_read_the_same(tmp_path: Path, ramp: np.ndarray, suffix: str) -> None:
    path = saved(tmp_path, suffix, ramp)
    assert io.open(path, untrusted=True) == io.open(path)


def test_untrusted_keeps_times_channels_and_choices(tmp_path: Path, ramp: np.ndarray) -> None:
    array = np.stack([[ramp, ramp + 1], [ramp + 2, ramp + 3]])
    volume = Volume(array, channel_names=("a", "b"), times=(0, 2.5), time_unit="s", no_data=7)
    io.save(volume, tmp_path / "a.nrrd")
    assert io.open(tmp_path / "a.nrrd", untrusted=True) == io.open(tmp_path / "a.nrrd")
    (tmp_path / "a.raw").write_bytes(ramp.tobytes())
    raw = {"shape": (5, 4, 3), "dtype": "int16", "spacing": (1, 2, 3)}
    assert io.open(tmp_path / "a.raw", untrusted=True, **raw) == io.open(tmp_path / "a.raw", **raw)


def test_untrusted_faults_are_those_of_a_plain_reading(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((3, 4, 5), complex))
    np.save(tmp_path / "b.npy", np.zeros((30, 40, 50)))
    for name, kind, keywords in (
        ("a.npy", DataError, {}),
        ("absent.npy", FileError, {}),
        ("b.npy", LimitError, {"max_memory": 1000}),
    ):
        with pytest.raises(kind) as plain:
            io.open(tmp_path / name, **keywords)
        with pytest.raises(kind) as apart:
            io.open(tmp_path / name, untrusted=True, **keywords)
        assert str(plain.value) == str(apart.value)


@pytest.mark.parametrize(
    ("deed", "what"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "crashed its reader"),
        ("import os; os._exit(3)", "exit code 3"),
        ("while True: pass", "took longer"),
        ("import time; time.sleep(1000)", "took longer"),
        ("hoard = [bytes(1 << 28) for _ in range(1000)]", "more memory"),
        ("raise SystemExit(0)", "exit code 0"),
        ("1 / 0", "ZeroDivisionError"),
    ],
)
def test_a_reader_that_goes_wrong_is_contained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deed: str, what: str) -> None:
    """A stand-in for the NumPy reader, put in place in the child by a module that Python imports at its start."""
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\nif '--multiprocessing-fork' not in sys.argv:\n    import airlight.io.npy as npy\n"
        f"    def read(path, options):\n        {deed}\n    npy.read = read\n"
    )
    np.save(tmp_path / "a.npy", np.zeros((3, 4, 5)))
    monkeypatch.syspath_prepend(str(tmp_path))
    limit_s = 0.5 if what == "took longer" else 20
    with pytest.raises(AirlightError, match=what):
        untrusted.read_untrusted(tmp_path / "a.npy", ReadOptions(max_bytes=1 << 28), time_limit_s=limit_s)


def test_signals_are_as_before(tmp_path: Path, ramp: np.ndarray) -> None:
    before = signal.getsignal(signal.SIGALRM)
    io.open(saved(tmp_path, ".npy", ramp), untrusted=True)
    assert signal.getsignal(signal.SIGALRM) is before


def test_nifti_pairs_read_apart(tmp_path: Path, ramp: np.ndarray) -> None:
    nibabel.save(nibabel.Nifti1Pair(ramp.T, np.eye(4)), tmp_path / "a.img")
    np.testing.assert_array_equal(io.open(tmp_path / "a.hdr").array, ramp)
    with pytest.raises(FileError):
        io.open(tmp_path / "a.img")
