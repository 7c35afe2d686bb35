"""Frames that are drawn again and again take no more memory."""

from __future__ import annotations

from pathlib import Path

import pytest

import airlight as al

FRAMES, MOST_BYTES = 20, 4 << 20
STATM = Path("/proc/self/statm")
PLANE = al.Clip.plane(point=(0, 0, 0), normal=(0, 1, 0))
BALL = al.Clip.sphere(center=(0, 0, 0), radius=1.0, keep="outside")
GLASS = al.Mesh([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 1, 2)], opacity=0.5)
WAYS = {
    "plain": {},
    "clipped": {"clips": [PLANE, BALL]},
    "first hit": {"look": al.Look(integrate=al.integrate.FirstHit(iso=2.0))},
    "sobel": {"look": al.Look(gradient="sobel")},
    "meshes": {"meshes": [GLASS]},
}


def resident_bytes() -> int:
    return int(STATM.read_text(encoding="ascii").split()[1]) * 4096


@pytest.mark.skipif(not STATM.exists(), reason="nothing tells how much memory is taken")
@pytest.mark.parametrize("way", WAYS)
def test_memory_does_not_grow(renderer: al.Renderer, way: str) -> None:
    # Where a branch or a loop is decided by a uniform alone, lavapipe compiles anew for each dispatch, and keeps it all.
    volume = al.samples.load("vortex", size=48)
    function = al.TransferFunction([(1.0, "gold", 0.0), (2.6, "white", 2.0)])
    scene = al.Scene(volume, transfer=function, camera="iso", **WAYS[way])
    for _ in range(5):
        renderer.render(scene, (128, 128))
    before = resident_bytes()
    for _ in range(FRAMES):
        renderer.render(scene, (128, 128))
    assert resident_bytes() - before < MOST_BYTES
