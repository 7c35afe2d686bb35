"""Reading in a child process with limits on memory and time: C parsers can crash, and a crash must not be the user's.

The child runs this module, gets its orders as JSON on standard input, and leaves the samples and what it found in a folder
that only this user can enter. Limits on memory need a POSIX system; the limit on time holds everywhere.
"""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import errors
from ..errors import AirlightError, FileError, LimitError
from ..volume import AnyArray, Source, Volume
from .options import ReadOptions
from .samples import byte_count, check_kind, load

TIME_LIMIT_S = 120.0
BASE_BYTES = 1 << 30  # address space of Python and the libraries, mostly reserved and never touched
TRAITS = ("units", "value_unit", "channel_names", "times", "time_unit", "no_data", "anatomical", "modality", "name")


def read_untrusted(path: Path, options: ReadOptions, time_limit_s: float = TIME_LIMIT_S) -> Volume:
    """Volume in a file of unknown origin; a crash, a hang or a hunger for memory ends as an error."""
    array, found = _in_child("volume", path, options, time_limit_s)
    source = Source(str(path), found["dataset"], found["level"], tuple((str(k), str(v)) for k, v in found["recipe"]))
    traits = {key: found[key] for key in TRAITS}
    return Volume(array, world_from_index=np.array(found["world_from_index"]), source=source, **traits)


def read_untrusted_picture(path: Path, options: ReadOptions, time_limit_s: float = TIME_LIMIT_S) -> AnyArray:
    """Pixels of an environment's picture of unknown origin, as ``environment.reading`` has them."""
    return _in_child("picture", path, options, time_limit_s)[0]


def _in_child(kind: str, path: Path, options: ReadOptions, time_limit_s: float) -> tuple[AnyArray, dict[str, Any]]:
    """Return the samples, and what else the child found."""
    options.progress(f"reading {path.name} in a process of its own", 0, 0)
    wishes = {key: value for key, value in asdict(replace(options, progress=_quiet)).items() if key != "progress"}
    with tempfile.TemporaryDirectory(prefix="airlight-") as folder:
        orders = {"kind": kind, "path": str(path.absolute()), "folder": folder, "options": wishes, "time_limit_s": time_limit_s}
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(part for part in sys.path if part),
            "OPENBLAS_NUM_THREADS": "1",  # each thread reserves address space
            "OMP_NUM_THREADS": "1",
        }
        try:
            child = subprocess.run(
                [sys.executable, "-P", "-m", "airlight.io.untrusted"],
                input=json.dumps(orders).encode(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=environment,
                timeout=time_limit_s + 5,  # the child's own clock counts its work, this one its sleep too
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            raise _too_slow(path, time_limit_s) from error
        return _collect(path, Path(folder), options, child.returncode, time_limit_s)


def _quiet(_what: str, _done: int, _total: int) -> None:
    pass


def _too_slow(path: Path, time_limit_s: float) -> FileError:
    return FileError(str(path), f"took longer than {time_limit_s:.0f} s to read", "it is damaged, hostile or very large")


def _collect(path: Path, folder: Path, options: ReadOptions, code: int, time_limit_s: float) -> tuple[AnyArray, dict[str, Any]]:
    report = folder / "report.json"
    if not report.exists():
        name = signal.Signals(-code).name if code < 0 else ""
        if name in ("SIGALRM", "SIGXCPU"):
            raise _too_slow(path, time_limit_s)
        if name == "SIGKILL":
            raise LimitError(str(path), "was killed while being read, perhaps for its memory", "choose a smaller file or level")
        if name:
            raise FileError(str(path), f"crashed its reader ({name})", "the file is damaged or hostile")
        raise FileError(str(path), f"ended its reader (exit code {code})", "the file is damaged or hostile")
    found: dict[str, Any] = json.loads(report.read_text())
    if "error" in found:
        kind = getattr(errors, str(found["error"]), FileError)
        raise kind(*(str(part) for part in found["parts"]))
    dtype, shape = np.dtype(str(found["dtype"])), tuple(int(n) for n in found["shape"])
    check_kind(str(path), dtype)
    byte_count(str(path), dtype, shape, options)
    return load(folder / "samples", dtype, shape, options), found


# -- the child


def _serve(orders: dict[str, Any]) -> None:
    from ..environment.reading import read_picture
    from . import read_trusted

    options = orders["options"]
    for key in ("shape_xyz", "spacing"):
        options[key] = None if options[key] is None else tuple(options[key])
    folder = Path(orders["folder"])
    try:
        _limit(options["max_bytes"], orders["time_limit_s"])
        path, choices = Path(orders["path"]), ReadOptions(**options)
        if orders["kind"] == "picture":
            _leave_array(read_picture(path, choices.max_bytes), folder, {})
        else:
            volume = read_trusted(path, choices)
            _leave_array(volume.array, folder, _found(volume))
    except AirlightError as error:
        _report(folder, {"error": type(error).__name__, "parts": [error.where, error.what, error.remedy]})
    except MemoryError:
        _report(folder, {"error": "LimitError", "parts": _out_of_memory(orders["path"]).__reduce__()[1]})


def _limit(max_bytes: int, time_limit_s: float) -> None:
    if sys.platform == "win32":
        return
    import resource

    def lower(kind: int, value: int) -> None:
        _, hard = resource.getrlimit(kind)
        resource.setrlimit(kind, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))

    memory = 2 * max_bytes + BASE_BYTES
    physical = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    lower(resource.RLIMIT_AS, min(memory, max(physical, BASE_BYTES)))
    lower(resource.RLIMIT_CPU, math.ceil(time_limit_s) + 1)
    lower(resource.RLIMIT_CORE, 0)
    lower(resource.RLIMIT_FSIZE, max_bytes + (1 << 20))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, time_limit_s)


def _leave_array(array: AnyArray, folder: Path, found: dict[str, Any]) -> None:
    with (folder / "samples").open("wb") as file:
        for part in array.reshape(-1, *array.shape[-2:]) if array.flags.c_contiguous else array:
            np.ascontiguousarray(part).tofile(file)
    _report(folder, {"dtype": array.dtype.str, "shape": array.shape} | found)


def _found(volume: Volume) -> dict[str, Any]:
    """What the report says of a volume beside its samples."""
    source = volume.source or Source("")
    found = {
        "world_from_index": volume.world_from_index.tolist(),
        "dataset": source.dataset,
        "level": source.level,
        "recipe": source.options,
    }
    return found | {key: getattr(volume, key) for key in TRAITS}


def _report(folder: Path, found: dict[str, Any]) -> None:
    unfinished = folder / "unfinished.json"
    unfinished.write_text(json.dumps(found))
    unfinished.rename(folder / "report.json")


def _out_of_memory(path: str) -> LimitError:
    return LimitError(path, "needs more memory than it may take", "raise --max-memory (max_memory=)")


if __name__ == "__main__":
    _serve(json.load(sys.stdin))
