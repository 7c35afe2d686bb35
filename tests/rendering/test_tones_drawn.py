"""Tones on the device: what is measured of the whole image, whatever part of it is drawn at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import blobs, function

import airlight as al
from airlight import reference
from airlight.rendering import tones

SIZE = (48, 40)
LOCAL = al.tone.ReinhardLocal(radius=0.08)


def seen(tone, scale: float = 1.0, **changed) -> al.Scene:
    """A lit picture with silhouettes, by an orthographic camera that sees ``scale`` times as much."""
    corners = blobs().corners_world()
    middle, reach = corners.mean(axis=0), np.ptp(corners, axis=0).max()
    camera = al.Camera.orthographic(
        eye=tuple(middle - (0.3 * reach, 2 * reach, 0)), target=tuple(middle), height=1.1 * scale * reach
    )
    look = al.Look(shade=al.shade.BlinnPhong(specular=5.0, shininess=40), tone=tone)
    return al.Scene(blobs(), transfer=function(), camera=camera, look=look, background=None, **changed)


@pytest.mark.parametrize("tone", [al.tone.Reinhard(), LOCAL, al.tone.Filmic()])
def test_exposure_does_not_depend_on_the_share_of_background(renderer, tone):
    """The same object with four times as much round it: the same pixels."""
    near = renderer.render(seen(tone), SIZE)
    wide = tone if tone != LOCAL else replace(LOCAL, radius=LOCAL.radius / 2)
    far = renderer.render(seen(wide, 2.0), (2 * SIZE[0], 2 * SIZE[1]))
    assert (near.rgba[..., 3] == 0).mean() > 0.1
    middle = far.rgba[SIZE[1] // 2 : -SIZE[1] // 2, SIZE[0] // 2 : -SIZE[0] // 2]
    assert far.stats["luminance"] == pytest.approx(near.stats["luminance"], rel=1e-5)
    # Cells of the local average lie elsewhere.
    assert np.abs(middle - near.rgba).max() < (1e-5 if tone != LOCAL else 0.02)


def test_parts_make_the_same_picture(renderer, monkeypatch):
    """Bands of rows, and tiles of them, that cut through the cells of the local average."""
    whole = renderer.render(seen(LOCAL), SIZE)
    few = renderer._device.limits | {"max-storage-buffer-binding-size": SIZE[0] * 16 * 7}
    monkeypatch.setattr(type(renderer._device), "limits", few)
    monkeypatch.setattr(tones, "MOST_TURNS", 12)
    parts = renderer.render(seen(LOCAL), SIZE)
    monkeypatch.undo()
    assert parts.stats["luminance"] == pytest.approx(whole.stats["luminance"], rel=1e-6)
    assert np.abs(parts.rgba - whole.rgba).max() < 1e-5
    assert np.abs(whole.rgba - reference.render(seen(LOCAL), SIZE).rgba).max() < 1 / 255


def test_what_is_measured_and_what_eyes_are_adapted_to(renderer):
    """The picture's own luminance is told whatever is taken for it; adaptation leads from one to the other."""
    drawn = renderer.render(seen("reinhard"), SIZE)
    known = renderer.render(seen(al.tone.Reinhard(adapted=drawn.stats["luminance"])), SIZE)
    assert known.rgba == pytest.approx(drawn.rgba, abs=1e-6)
    eye, errors = al.tone.Adaptation(16 * drawn.stats["luminance"]), []
    for _ in range(4):
        image = renderer.render(seen(al.tone.Reinhard(adapted=eye.luminance)), SIZE)
        assert image.stats["luminance"] == drawn.stats["luminance"]
        errors.append(np.abs(image.rgba - drawn.rgba).max())
        eye = eye.adapted(image, 1.0)
    assert errors == sorted(errors, reverse=True)
    assert errors[3] < 0.2 * errors[0]
    assert "luminance" not in renderer.render(seen("linear"), SIZE).stats


def test_a_bright_highlight_is_brought_back(renderer):
    """Vollrath, Weiskopf and Ertl, figure 6: what is beyond 1 as it comes has structure again, and nothing else gets lost."""
    shown = {}
    for tone in ("linear", al.tone.Reinhard(white=20), replace(LOCAL, white=20.0), "filmic"):
        shown[getattr(tone, "name", tone)] = renderer.render(seen(tone, lights=[al.Light.head(intensity=4)]), SIZE)
    linear = shown.pop("linear")
    burnt = linear.picture()[..., :3].min(axis=-1) == 255
    assert burnt.sum() > 20
    for image in shown.values():
        assert (image.picture()[burnt][:, :3].min(axis=-1) < 255).mean() > 0.9
        assert image.rgba[..., 3] == pytest.approx(linear.rgba[..., 3])
        order = np.argsort(linear.rgba[burnt][:, 1])
        assert np.corrcoef(np.arange(len(order)), np.argsort(np.argsort(image.rgba[burnt][order, 1])))[0, 1] > 0.5


ENDS = [
    al.tone.Reinhard(white=1e-3, exposure=32.0, key=1.0, adapted=1e-30),
    al.tone.Reinhard(white=1e30, key=1e-6),
    al.tone.Filmic(white=1e9, contrast=4.0),
    al.tone.Filmic(white=1.01, contrast=1.0, exposure=32.0),
]


@pytest.mark.parametrize("tone", ENDS)
def test_parameters_at_the_ends_of_their_ranges(renderer, tone):
    radiance = renderer.render(seen("linear"), SIZE).rgba.astype(np.float64)
    assert renderer.render(seen(tone), SIZE).rgba == pytest.approx(
        reference.tone.TONES[tone.name](tone, radiance), rel=1e-3, abs=1e-6
    )
