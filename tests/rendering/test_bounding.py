"""Rays from the first face of what holds something to the last: the image stays as it is, with fewer samples."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scenes import SIZE, blobs, cameras, function, scene
from test_skipping import FUNCTIONS, islands

import airlight as al
from airlight.errors import StageError, ValueRangeError
from airlight.rendering.bounding import border_faces

LEVEL = 1 / 255


@given(arrays(bool, st.tuples(*[st.integers(1, 4)] * 3)))
def test_faces_close_what_is_active(active: np.ndarray) -> None:
    faces = border_faces(active)
    # Each edge is passed as often in one direction as in the other.
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 6)
    there = {tuple(edge): 0 for edge in edges}
    for edge in edges:
        there[tuple(edge)] += 1
    assert all(there[edge] == there.get((*edge[3:], *edge[:3]), 0) for edge in there)
    # By the divergence theorem they enclose as many blocks as are active, which tells that they look outwards.
    middle, normal = faces.mean(axis=1), np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 1])
    assert np.einsum("ij,ij->", middle, normal) / 3 == pytest.approx(active.sum())


@pytest.mark.parametrize("name", ["hill", "glow", "steps"])
@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 8),
    camera=st.sampled_from(["perspective", "inside", "orthographic", "cut"]),
    step=st.sampled_from([0.7, 1.0, 1.9]),
)
def test_the_image_is_the_same(renderer: al.Renderer, name: str, seed: int, count: int, camera: str, step: float) -> None:
    volume = islands(seed, count)
    drawn = al.Scene(volume, transfer=FUNCTIONS[name], camera=cameras(volume)[camera], background=None)
    bounded, whole = (renderer.render(drawn, SIZE, step=step, skip=skip) for skip in ("geometry", "none"))
    assert np.abs(bounded.rgba - whole.rgba).max() <= LEVEL
    assert np.mean(np.isfinite(bounded.depth) != np.isfinite(whole.depth)) <= 2e-3


@pytest.mark.parametrize("camera", ["perspective", "inside"])
def test_fewer_samples_than_by_blocks_alone(any_renderer: al.Renderer, camera: str) -> None:
    drawn = scene(camera=camera, integrate=al.integrate.FirstHit(iso=70.0))
    bounded, by_blocks = (any_renderer.render(drawn, SIZE, skip=skip) for skip in ("geometry", "blocks"))
    assert np.abs(bounded.rgba - by_blocks.rgba).max() <= 1e-5
    assert bounded.stats["samples"] <= by_blocks.stats["samples"]
    assert bounded.stats["skip"]["done"] == "geometry"
    # A grid whose axes are turned over has faces that look the same way.
    matrix = blobs().world_from_index @ np.diag([-1.0, 1.0, 1.0, 1.0])
    turned = al.Volume(blobs().array, world_from_index=matrix)
    mirrored = al.Scene(turned, transfer=function(), camera=cameras(turned)[camera], background=None)
    one, other = (any_renderer.render(mirrored, SIZE, skip=skip) for skip in ("geometry", "none"))
    assert np.abs(one.rgba - other.rgba).max() <= LEVEL


def test_rays_on_the_border_of_the_domain_are_drawn(renderer: al.Renderer) -> None:
    """Rasterisers leave out pixels whose middle lies right on an edge."""
    volume = al.Volume(np.ascontiguousarray(blobs().array[:33, :33, :17]), origin=(1e6, 0, 0))
    middle = volume.corners_world().mean(axis=0)
    camera = al.Camera.orthographic(eye=tuple(middle - (50, 0, 0)), target=tuple(middle), up=(0, 0, 1), height=40)
    rising = al.TransferFunction([(-100, "red", 0.2), (60, "blue", 0.2), (80, "blue", 0), (200, "blue", 0)])
    drawn = al.Scene(volume, transfer=rising, camera=camera, background=None)
    bounded, whole = (renderer.render(drawn, (5, 5), skip=skip) for skip in ("geometry", "none"))
    assert np.abs(bounded.rgba - whole.rgba).max() <= LEVEL


def test_where_there_is_no_geometry(renderer: al.Renderer) -> None:
    for look, found in (
        ({"integrate": "mip", "shade": "none"}, "knows of no blocks"),
        ({"camera": "dome"}, "cannot draw faces"),
    ):
        camera = (
            al.Camera.dome(eye=(0, 0, 0), target=(0, 1, 0)) if look.pop("camera", None) else cameras(blobs())["perspective"]
        )
        drawn = al.Scene(blobs(), transfer=function(), camera=camera, look=al.Look(**look))
        with pytest.raises(StageError, match=found):
            renderer.render(drawn, SIZE, skip="geometry")
    with pytest.raises(ValueRangeError, match="skip is 'geometry', and the driver is slices"):
        renderer.render(scene(), SIZE, skip="geometry", driver="slices")
    with pytest.raises(StageError, match="is for whole images"):
        renderer.render(scene(), SIZE, skip="geometry", tolerance=0.01)
