"""Volumes and transfer functions of the benchmarks."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np

import airlight as al
from airlight.benchmark.scenes import bone as bone
from airlight.benchmark.scenes import flow as flow
from airlight.benchmark.scenes import haze as haze
from airlight.benchmark.scenes import head as head
from airlight.benchmark.scenes import noisy_cloud as noisy_cloud
from airlight.benchmark.scenes import stand_in as stand_in

ROOT = Path(__file__).parent.parent
FILES = {"ct_head": "ct_head.nrrd", "ch2": "ch2.nii.gz", "engine": "engine.nii.gz", "bonsai": "bonsai.nii.gz"}


def data_folder() -> Path:
    """Folder of the real volumes: ``AIRLIGHT_DATA``, else ``shared/data`` beside the project."""
    return Path(os.environ.get("AIRLIGHT_DATA") or ROOT.parent / "shared" / "data")


def real_path(name: str) -> Path | None:
    """File of a real volume, None where it is not there."""
    path = data_folder() / FILES[name]
    return path if path.is_file() else None


def real_volume(name: str, voxels: int = 96) -> al.Volume:
    """Return a real volume, or a computed head-like one in its place, which says so in its name."""
    path = real_path(name)
    if path is not None:
        return al.open(path)
    where = "AIRLIGHT_DATA names the folder of real volumes"
    print(f"{FILES[name]} is not there ({where}); a computed volume stands in", file=sys.stderr)
    return stand_in(voxels)


def cropped(volume: al.Volume, size: int) -> al.Volume:
    """Return the middle of a volume, at most so many voxels along each axis, for quick runs."""
    starts = [(n - min(n, size)) // 2 for n in volume.array.shape]
    part = volume.array[tuple(slice(a, a + min(n, size)) for a, n in zip(starts, volume.array.shape, strict=True))]
    matrix = volume.world_from_index.copy()
    matrix[:3, 3] = (volume.world_from_index @ [*starts[::-1], 1])[:3]
    about = {"units": volume.units, "modality": volume.modality, "anatomical": volume.anatomical}
    return al.Volume(np.ascontiguousarray(part), world_from_index=matrix, name=f"{volume.name} (cropped)", **about)


def brain() -> al.TransferFunction:
    """Skin and brain of an MRI of 8 bits."""
    return al.TransferFunction(
        [(30, (0.3, 0.15, 0.1), 0), (70, (0.7, 0.45, 0.3), 0.03), (110, (0.8, 0.75, 0.7), 0.1), (200, (1, 1, 1), 0.5)]
    )
