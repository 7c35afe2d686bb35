"""Volumes and transfer functions that any machine can compute."""

from __future__ import annotations

import numpy as np

from ..transfer import TransferFunction
from ..volume import Volume, statistics


def stand_in(voxels: int = 96) -> Volume:
    """Nested ellipsoids with the values of air, skin, tissue and bone in Hounsfield units."""
    axis = np.linspace(-1, 1, voxels)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    radius = np.sqrt((x / 0.8) ** 2 + (y / 0.9) ** 2 + (z / 0.85) ** 2) + 0.03 * np.sin(9 * x) * np.cos(8 * y) * np.sin(7 * z)
    values = np.interp(radius, [0, 0.7, 0.75, 0.85, 0.9, 1.0, 1.05], [40, 40, 1200, 1200, 60, 60, -1000])
    spacing = (200 / voxels,) * 3
    return Volume(np.round(values).astype(np.int16), spacing=spacing, units="mm", modality="CT", name="computed stand-in")


def noisy_cloud(voxels: int = 256, seed: int = 1) -> Volume:
    """A smooth cloud with noise on it, whole numbers of 8 bits, nowhere empty."""
    axis = np.linspace(-1, 1, voxels, dtype=np.float32)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    smooth = 90 * np.exp(-1.5 * (x * x + y * y + z * z)) + 30 * np.sin(7 * x) * np.cos(6 * y) * np.sin(5 * z) + 80
    noise = np.random.default_rng(seed).normal(0, 12, (voxels,) * 3).astype(np.float32)
    return Volume(np.clip(smooth + noise, 1, 255).astype(np.uint8), name=f"cloud-{voxels}")


def bone() -> TransferFunction:
    """Bone of a CT: opaque from 600 HU on, all below 150 HU empty."""
    return TransferFunction(
        [(150, (0.26, 0.1, 0.04), 0), (280, (0.7, 0.45, 0.26), 0.05), (600, (0.9, 0.8, 0.63), 0.6), (1600, (1, 1, 1), 1.6)]
    )


def head() -> TransferFunction:
    """Translucent skin and tissue over bone of a CT."""
    return TransferFunction(
        [
            (-600, (0.5, 0.25, 0.15), 0),
            (-300, (0.7, 0.4, 0.28), 0.02),
            (60, (0.6, 0.1, 0.08), 0.01),
            (250, (0.8, 0.6, 0.4), 0.06),
            (900, (1, 0.95, 0.85), 0.9),
        ]
    )


def haze(volume: Volume, depth: float = 1.5) -> TransferFunction:
    """Return a function without an empty value: the whole volume is a haze of about this optical depth."""
    known = statistics(volume)
    low, high = float(known.minimum), float(known.maximum)
    extent = max(n * s for n, s in zip(volume.size, volume.spacing, strict=True))
    e = depth / extent
    middle = (low + high) / 2
    return TransferFunction([(low, (0.2, 0.3, 0.6), 0.3 * e), (middle, (0.9, 0.6, 0.3), e), (high, (1, 1, 1), 2 * e)])


def flow() -> TransferFunction:
    """Function of the speed of the vortex field."""
    return TransferFunction(
        [(0.2, (0.1, 0.2, 0.9), 0.6), (1.2, (0.1, 0.7, 0.5), 0.0), (2.2, (0.9, 0.8, 0.2), 0.2), (3.4, (1, 0.3, 0.1), 4.0)]
    )


def shells(voxels: int) -> Volume:
    """Nested shells in a ball: some space is empty, some is dense."""
    axis = np.linspace(-1, 1, voxels, dtype=np.float32)
    radius = np.sqrt(axis[:, None, None] ** 2 + axis[None, :, None] ** 2 + axis[None, None, :] ** 2)
    values = np.where(radius < 1, 0.5 + 0.5 * np.cos(12 * np.pi * radius), 0) * 255
    return Volume(values.astype(np.uint8), name="shells")
