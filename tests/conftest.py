"""Fixtures that all tests share."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

import airlight as al
from airlight.gpu.device import Device, choose

settings.register_profile("ci", max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("ci")

# Python keeps what it compiled, even where it is told not to: more than a hundred processes of the tests import the package.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

ROOT = Path(__file__).parent.parent
KEEP_BYTES = 1 << 30  # thousands of programs are drawn with: those of tests that are over need not stay


def pytest_collection_finish() -> None:
    """What was collected stays: whoever collects garbage need not look at thousands of tests again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _strict_numpy():
    with np.errstate(all="raise", under="ignore"):
        yield


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20260101)


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Real volumes; tests that use them are marked ``data``."""
    folder = Path(os.environ.get("AIRLIGHT_DATA") or ROOT.parent / "shared" / "data")
    if not folder.is_dir():
        pytest.skip(f"no real volumes: {folder} is not there (AIRLIGHT_DATA names another folder)")
    return folder


@pytest.fixture(scope="session")
def renderer():
    with al.Renderer(keep_bytes=KEEP_BYTES) as made:
        yield made


@pytest.fixture(scope="session")
def core_renderer():
    """Renderer on a device with core WebGPU's limits and no optional feature."""
    with al.Renderer(keep_bytes=KEEP_BYTES) as made:
        opened = made._open

        def open_core() -> Device:
            # The first time, and after a device was lost.
            with pytest.MonkeyPatch.context() as patch:
                patch.setenv("AIRLIGHT_CORE", "1")
                return opened()

        made._open = lambda: made._device or open_core()
        made._thread.submit(lambda job: made._open()).result()
        yield made


@pytest.fixture(params=["full", "core"])
def any_renderer(request, renderer, core_renderer):
    return {"full": renderer, "core": core_renderer}[request.param]


@pytest.fixture
def either_renderer(request, renderer, core_renderer):
    """Both kinds of devices in turns, as the squares of a chessboard: each value of each of a test's parameters meets both.

    For what does not ask a device for more than another; ``any_renderer`` draws every case on both.
    """
    place = sum(_place(request.node.callspec.params, *mark.args) for mark in request.node.iter_markers("parametrize"))
    return (renderer, core_renderer)[place % 2]


def _place(params: dict[str, Any], names: str | Sequence[str], cases: Iterable[Any]) -> int:
    """Where in its list a parameter is, or several that go together."""
    if isinstance(names, str):
        return next(k for k, value in enumerate(cases) if value is params[names])
    return next(k for k, case in enumerate(cases) if all(a is params[b] for a, b in zip(case, names, strict=True)))


@pytest.fixture(scope="module")
def device():
    made = Device(*choose(), core=False)
    yield made
    made.close()


@pytest.fixture(scope="module")
def core_device():
    made = Device(*choose(), core=True)
    yield made
    made.close()
