"""Fixtures of the tests of readers and writers."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

PROJECT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of real volumes: ``AIRLIGHT_DATA``, else ``../shared/data`` from the project's root; skips without it."""
    folder = Path(os.environ.get("AIRLIGHT_DATA") or PROJECT.parent / "shared" / "data")
    if not folder.is_dir():
        pytest.skip(f"no real volumes: {folder} is absent (AIRLIGHT_DATA names another folder)")
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for the files of a module, which hypothesis' examples share."""
    return tmp_path_factory.mktemp("io")


@pytest.fixture
def ramp() -> np.ndarray:
    """Small int16 array (z, y, x) = (3, 4, 5) in which every voxel is another value."""
    return np.arange(60, dtype=np.int16).reshape(3, 4, 5)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Thousands of damaged files only when asked for by ``-m fuzz``."""
    if "fuzz" in (config.getoption("-m") or ""):
        return
    for item in items:
        if item.get_closest_marker("fuzz"):
            item.add_marker(pytest.mark.skip(reason="thousands of inputs: asked for by -m fuzz"))
