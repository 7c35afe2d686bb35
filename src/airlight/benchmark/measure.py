"""Time and error: repeated runs of jobs, and how far images are from each other."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

# -- time


@dataclass
class Measured:
    """Repeated runs of one job: seconds of wall and of all this process's cores, and what the last run returned."""

    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    result: Any = None

    def run(self, job: Callable[[], Any], counted: bool = True) -> None:
        """Run a job once."""
        wall, cpu = time.perf_counter(), time.process_time()
        self.result = job()
        if counted:
            self.wall.append(time.perf_counter() - wall)
            self.cpu.append(time.process_time() - cpu)

    def summary(self) -> dict[str, Any]:
        """Median, least and greatest in milliseconds."""
        return {"wall_ms": spread(1e3 * np.array(self.wall)), "cpu_ms": spread(1e3 * np.array(self.cpu))}


def spread(values: Any) -> dict[str, float]:
    """Median, minimum and maximum."""
    values = np.asarray(values, dtype=np.float64)
    return {"median": float(np.median(values)), "min": float(values.min()), "max": float(values.max()), "n": int(values.size)}


def side_by_side(
    jobs: Mapping[str, Callable[[], Any]],
    repeats: int,
    warm: int = 1,
    *,
    seconds: float = math.inf,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, Measured]:
    """Run jobs in turns, A B A B, so that whatever slows the machine down meets all of them; the first turns do not count.

    No further turn begins once so many seconds have passed and one has counted.
    """
    measured = {name: Measured() for name in jobs}
    end = clock() + seconds
    for turn in range(warm + repeats):
        if turn > warm and clock() >= end:
            break
        for name, job in jobs.items():
            measured[name].run(job, counted=turn >= warm)
    return measured


def ratio(one: Sequence[float], other: Sequence[float]) -> dict[str, float]:
    """Quotients ``one / other`` of the same turns."""
    return spread(np.asarray(one) / np.asarray(other))


# -- errors of images


def errors(image: Any, truth: Any) -> dict[str, float]:
    """Greatest and root mean square difference of linear, premultiplied colours and opacity, and PSNR for a peak of one."""
    difference = np.asarray(image, dtype=np.float64) - np.asarray(truth, dtype=np.float64)
    rmse = float(np.sqrt(np.mean(difference**2)))
    return {"max": float(np.abs(difference).max()), "rmse": rmse, "psnr_db": psnr(rmse)}


def psnr(rmse: float) -> float:
    """Peak signal to noise ratio in decibel for a peak of one; 200 where the images are equal."""
    return float(-20 * np.log10(max(rmse, 1e-10)))
