"""Surfaces that were kept, lit again: the same as drawing anew; and their normals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, function, scene

import airlight as al
from airlight.errors import DataError, StageError

TWO_SIDES = al.TransferFunction.from_surfaces([al.Surface(60.0, "gold", back_colour="blue")])


def iso(camera="perspective", **look) -> al.Scene:
    return scene(camera=camera, field="linear_exact", integrate=al.integrate.FirstHit(iso=60.0), **look)


def changed(drawn: al.Scene, tf=None, **look) -> al.Scene:
    layer = drawn.layers[0]
    return replace(drawn, layers=[replace(layer, transfer=tf or layer.transfer, look=replace(layer.look, **look))])


CHANGES = {
    "nothing": lambda drawn: drawn,
    "lights": lambda drawn: replace(drawn, lights=[al.Light.directional(to_light=(1, 2, 0.5), color=(1, 0.5, 0.2))]),
    "no light": lambda drawn: replace(drawn, lights=[]),
    "material": lambda drawn: changed(
        drawn, shade=al.shade.BlinnPhong(ambient=0.3, specular=0.6, shininess=4, two_sided=False)
    ),
    "colours": lambda drawn: changed(drawn, tf=TWO_SIDES),
    "tone": lambda drawn: changed(drawn, tone="reinhard"),
    "background": lambda drawn: replace(drawn, background=(0.2, 0.4, 0.6)),
    "unlit": lambda drawn: changed(drawn, shade="none"),
}


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("change", CHANGES)
def test_lit_again_is_drawn_anew(either_renderer, camera, change):
    first = iso(camera)
    image = either_renderer.render(first, SIZE, keep_hits=True)
    other = CHANGES[change](first)
    again, anew = either_renderer.relight(image, other), either_renderer.render(other, SIZE)
    assert np.abs(again.rgba - anew.rgba).max() < 2e-4
    assert np.abs(again.rgb - anew.rgb).max() < 2e-4
    assert np.array_equal(again.depth, anew.depth)
    assert again.stats["samples"] == 0
    if change in ("lights", "material", "colours", "unlit"):
        assert np.abs(again.rgba - image.rgba).max() > 0.05


def test_meshes_are_refused_where_they_would_not_be_drawn(renderer):
    drawn = iso()
    image = renderer.render(drawn, SIZE, keep_hits=True)
    with pytest.raises(StageError, match="not meshes"):
        renderer.relight(image, replace(drawn, meshes=[al.Lines.box(blobs())]))


def test_an_unlit_picture_is_lit_again(any_renderer):
    """Nothing asks for gradients while it is drawn, light will."""
    unlit, lit = iso(shade="none"), iso()
    image = any_renderer.render(unlit, SIZE, keep_hits=True)
    assert np.array_equal(image.rgba, any_renderer.render(unlit, SIZE).rgba)
    again, anew = any_renderer.relight(image, lit), any_renderer.render(lit, SIZE, keep_hits=True)
    assert np.abs(again.rgba - anew.rgba).max() < 2e-4
    assert np.abs(image.normal - anew.normal).max() < 1e-4
    assert np.abs(again.rgba - image.rgba).max() > 0.05


def test_keeping_changes_nothing(any_renderer):
    plain, kept = (any_renderer.render(iso(), SIZE, keep_hits=keep) for keep in (False, True))
    assert np.array_equal(plain.rgba, kept.rgba)
    assert plain.hits is None


def test_normals_are_those_of_the_field(any_renderer):
    """The distance from a point: normals point away from it."""
    z, y, x = np.mgrid[-1:1:40j, -1:1:40j, -1:1:40j]
    volume = al.Volume((1 - np.sqrt(x * x + y * y + z * z)).astype(np.float32), spacing=(1, 1, 1))
    look = al.Look(field="linear_exact", integrate=al.integrate.FirstHit(iso=0.4))
    tf = al.TransferFunction([(0, "white", 0), (1, "white", 1)])
    drawn = al.Scene(volume, transfer=tf, camera=cameras(volume)["perspective"], look=look)
    image = any_renderer.render(drawn, SIZE, keep_hits=True)
    met = np.isfinite(image.depth)
    assert 0.05 < met.mean() < 0.9
    assert (image.normal[~met] == 0).all()
    points = [al.pick(image, drawn, (int(c), int(r))) for r, c in zip(*np.nonzero(met), strict=True)]
    away = np.array(points) - 19.5
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    assert (image.normal[met] * away).sum(axis=1).min() > 0.999


def test_sides_are_told(renderer):
    """From outside surfaces are met on the way up, from inside on the way down, and rays may begin beyond them."""
    outside = renderer.render(iso("perspective"), SIZE, keep_hits=True)
    assert set(np.unique(outside.hits.side)) == {0, 1}
    inside = iso("inside")
    sheet = changed(inside, integrate=al.integrate.FirstHit(iso=60.0, side="both"))
    assert 2 in renderer.render(sheet, SIZE, keep_hits=True).hits.side
    assert 3 in renderer.render(inside, SIZE, keep_hits=True).hits.side


def test_what_cannot_be_lit_again(renderer):
    drawn = iso()
    image = renderer.render(drawn, SIZE, keep_hits=True)
    elsewhere = replace(drawn, camera=cameras(blobs())["orthographic"])
    with pytest.raises(DataError, match="camera"):
        renderer.relight(image, elsewhere)
    with pytest.raises(DataError, match="integrate"):
        renderer.relight(image, changed(drawn, integrate=al.integrate.FirstHit(iso=61.0)))
    with pytest.raises(DataError, match="gradient"):
        renderer.relight(image, changed(drawn, gradient="sobel"))
    with pytest.raises(DataError, match="scene has 0 visible layers"):
        renderer.relight(image, replace(drawn, layers=[replace(drawn.layers[0], visible=False)]))
    with pytest.raises(DataError, match="scene is a str"):
        renderer.relight(image, "x")
    with pytest.raises(DataError, match="image is a NoneType"):
        renderer.relight(None, drawn)
    with pytest.raises(DataError, match="keep_hits"):
        renderer.relight(renderer.render(drawn, SIZE), drawn)
    with pytest.raises(DataError, match="kept"):
        _ = renderer.render(drawn, SIZE).normal
    with pytest.raises(StageError, match="meets no surfaces that could be kept: use first_hit"):
        renderer.render(scene(integrate="mip"), SIZE, keep_hits=True)
    with pytest.raises(StageError, match="meets no surfaces that could be lit again: use first_hit"):
        renderer.relight(renderer.render(scene(), SIZE, keep_hits=True), scene())
    with pytest.raises(StageError, match="use shade='none'"):
        renderer.relight(image, changed(drawn, lighting="unlit"))


@pytest.mark.parametrize("look", [{}, {"shade": "none"}, {"gradient": "sobel", "field": "bspline"}])
def test_normals_of_a_volume_are_those_where_it_becomes_opaque(any_renderer, look):
    drawn = scene(**look)
    image = any_renderer.render(drawn, SIZE, keep_hits=True)
    assert np.abs(image.rgba - any_renderer.render(drawn, SIZE).rgba).max() <= 1e-6
    met = np.isfinite(image.depth)
    assert met.sum() > 100
    assert np.array_equal(image.hits.side == 4, met)
    assert not image.normal[~met].any()
    for y, x in np.argwhere(met)[::37]:
        assert image.normal[y, x] == pytest.approx(image.pick(int(x), int(y)).normal, abs=2e-3)


def test_normals_of_a_mixture(renderer):
    mixed = al.Volume(np.stack([blobs().array, 120 - blobs().array]), world_from_index=blobs().world_from_index)
    drawn = al.Scene(mixed, transfer=[function(), function()], camera=scene().camera)
    image = renderer.render(drawn, SIZE, keep_hits=True)
    lengths = np.linalg.norm(image.normal[np.isfinite(image.depth)], axis=-1)
    assert np.quantile(np.abs(lengths - 1), 0.95) < 1e-5
