"""Volumes and transfer functions of the benchmarks."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np

import airlight as al

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


def stand_in(voxels: int = 96) -> al.Volume:
    """Nested ellipsoids with the values of air, skin, tissue and bone in Hounsfield units."""
    axis = np.linspace(-1, 1, voxels)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    radius = np.sqrt((x / 0.8) ** 2 + (y / 0.9) ** 2 + (z / 0.85) ** 2) + 0.03 * np.sin(9 * x) * np.cos(8 * y) * np.sin(7 * z)
    values = np.interp(radius, [0, 0.7, 0.75, 0.85, 0.9, 1.0, 1.05], [40, 40, 1200, 1200, 60, 60, -1000])
    spacing = (200 / voxels,) * 3
    return al.Volume(np.round(values).astype(np.int16), spacing=spacing, units="mm", modality="CT", name="computed stand-in")


def cropped(volume: al.Volume, size: int) -> al.Volume:
    """Return the middle of a volume, at most so many voxels along each axis, for quick runs."""
    starts = [(n - min(n, size)) // 2 for n in volume.array.shape]
    part = volume.array[tuple(slice(a, a + min(n, size)) for a, n in zip(starts, volume.array.shape, strict=True))]
    matrix = volume.world_from_index.copy()
    matrix[:3, 3] = (volume.world_from_index @ [*starts[::-1], 1])[:3]
    about = {"units": volume.units, "modality": volume.modality, "anatomical": volume.anatomical}
    return al.Volume(np.ascontiguousarray(part), world_from_index=matrix, name=f"{volume.name} (cropped)", **about)


def noisy_cloud(voxels: int = 256, seed: int = 1) -> al.Volume:
    """A smooth cloud with noise on it, whole numbers of 8 bits, nowhere empty."""
    axis = np.linspace(-1, 1, voxels, dtype=np.float32)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    smooth = 90 * np.exp(-1.5 * (x * x + y * y + z * z)) + 30 * np.sin(7 * x) * np.cos(6 * y) * np.sin(5 * z) + 80
    noise = np.random.default_rng(seed).normal(0, 12, (voxels,) * 3).astype(np.float32)
    return al.Volume(np.clip(smooth + noise, 1, 255).astype(np.uint8), name=f"cloud-{voxels}")


def bone() -> al.TransferFunction:
    """Bone of a CT: opaque from 600 HU on, all below 150 HU empty."""
    return al.TransferFunction(
        [(150, (0.26, 0.1, 0.04), 0), (280, (0.7, 0.45, 0.26), 0.05), (600, (0.9, 0.8, 0.63), 0.6), (1600, (1, 1, 1), 1.6)]
    )


def head() -> al.TransferFunction:
    """Translucent skin and tissue over bone of a CT."""
    return al.TransferFunction(
        [
            (-600, (0.5, 0.25, 0.15), 0),
            (-300, (0.7, 0.4, 0.28), 0.02),
            (60, (0.6, 0.1, 0.08), 0.01),
            (250, (0.8, 0.6, 0.4), 0.06),
            (900, (1, 0.95, 0.85), 0.9),
        ]
    )


def brain() -> al.TransferFunction:
    """Skin and brain of an MRI of 8 bits."""
    return al.TransferFunction(
        [(30, (0.3, 0.15, 0.1), 0), (70, (0.7, 0.45, 0.3), 0.03), (110, (0.8, 0.75, 0.7), 0.1), (200, (1, 1, 1), 0.5)]
    )


def haze(volume: al.Volume, depth: float = 1.5) -> al.TransferFunction:
    """Return a function without an empty value: the whole volume is a haze of about this optical depth."""
    known = al.statistics(volume)
    low, high = float(known.minimum), float(known.maximum)
    extent = max(n * s for n, s in zip(volume.size, volume.spacing, strict=True))
    e = depth / extent
    middle = (low + high) / 2
    return al.TransferFunction([(low, (0.2, 0.3, 0.6), 0.3 * e), (middle, (0.9, 0.6, 0.3), e), (high, (1, 1, 1), 2 * e)])


def flow() -> al.TransferFunction:
    """Function of the speed of the vortex field."""
    return al.TransferFunction(
        [(0.2, (0.1, 0.2, 0.9), 0.6), (1.2, (0.1, 0.7, 0.5), 0.0), (2.2, (0.9, 0.8, 0.2), 0.2), (3.4, (1, 0.3, 0.1), 4.0)]
    )
