"""Where within a slab light is evaluated: errors, what is kept from slab to slab, kinds of functions, weak gradients."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, scene

import airlight as al
from airlight import reference
from airlight.reference.shade import surfaceness

WAYS = {
    "front": al.lighting.Sampled(at="front"),
    "middle": al.lighting.Sampled(at="middle"),
    "light": al.lighting.Sampled(),
    "averaged": al.lighting.Averaged(),
    "interpolated": al.lighting.Interpolated(),
}
KEEPING = ["averaged", "interpolated"]


def agree(renderer, drawn, step=1.0, share=1.0):
    image, truth = renderer.render(drawn, SIZE, step=step), reference.render(drawn, SIZE, step=step)
    assert np.quantile(np.abs(image.rgba - truth.rgba).max(axis=-1), share) <= 1 / 255


@pytest.mark.parametrize("way", WAYS)
def test_ways_agree_with_the_reference(core_renderer, way):
    for step in (0.7, 2.0):
        agree(core_renderer, scene(lighting=WAYS[way]), step)


@pytest.mark.parametrize("way", KEEPING)
@pytest.mark.parametrize("camera", ["inside", "cut"])
def test_what_is_kept_from_slab_to_slab(renderer, way, camera):
    """With stretches that are skipped, samples that are empty, and an eye inside, ends are lit anew where they must be."""
    holed = blobs().array.copy()
    holed[10:25, 12:20, 8:22] = np.nan
    volume = al.Volume(holed, world_from_index=blobs().world_from_index)
    # Beside holes gradients jump, so that what tables are off by is seen.
    for drawn, share in ((scene(camera=camera, lighting=way), 1.0), (scene(volume, camera=camera, lighting=way), 0.995)):
        agree(renderer, drawn, share=share)
        kept, all_taken = (renderer.render(drawn, SIZE, skip=skip).rgba for skip in ("auto", "none"))
        assert np.abs(kept - all_taken).max() < 2e-4


@pytest.mark.parametrize("way", ["light", "interpolated"])
def test_slabs_of_all_kinds_tell_where_their_light_comes_from(renderer, way):
    base = scene(lighting=WAYS[way])
    look, camera, volume = base.layers[0].look, base.camera, base.layers[0].volume
    ramp = al.TransferFunction([(40, "black", 0), (70, "orange", 0.1), (110, "white", 1.0)])
    sheets = [al.Surface(60, "red", 0.4, "blue"), al.Surface(80, "lime", 0.6, "blue")]
    for function in (ramp.with_surfaces(sheets), al.TransferFunction.from_surfaces(sheets)):
        agree(renderer, al.Scene(volume, transfer=function, camera=camera, look=look, background=None))


def facets(n=24):
    """A field that is straight along z, and whose gradient turns along it; seen along z."""
    z, y, x = np.mgrid[:n, :n, :n].astype(np.float64) - (n - 1) / 2
    values = 50 + z * (5 + 2 * np.sin(x / 3) * np.sin(y / 3)) + 12 * np.cos(x / 4) * np.cos(y / 5)
    volume = al.Volume(values.astype(np.float32))
    middle = (n - 1) / 2
    camera = al.Camera.orthographic(
        eye=(middle, middle, middle - 30.8), target=(middle, middle, middle), up=(0, 1, 0), height=n - 3
    )
    return volume, camera


@pytest.mark.parametrize("function", ["peak", "step"])
def test_interpolated_light_has_no_bands(renderer, function):
    """Errors of light alone: classification is exact along straight lines (Lum, Wilson and Ma, section 3)."""
    volume, camera = facets()
    tf = {
        "peak": al.TransferFunction([(49, "white", 0), (50, "white", 2), (51, "white", 0)]),
        "step": al.TransferFunction([(50, "white", 0), (50, "white", 20)]),
    }[function]
    lights = [al.Light.directional(to_light=(-1, -1, -1.5))]

    def drawn(way):
        look = al.Look(field="linear_exact", lighting=WAYS[way], shade=al.shade.BlinnPhong(specular=0.3, shininess=40))
        return al.Scene(volume, transfer=tf, camera=camera, look=look, lights=lights, background=None)

    truth = reference.render(drawn("middle"), (24, 24), step=1 / 32).rgba
    error = {way: np.sqrt(np.mean((renderer.render(drawn(way), (24, 24)).rgba - truth) ** 2)) for way in WAYS}
    assert error["interpolated"] < error["averaged"] / 3
    assert error["interpolated"] < error["front"] / 5
    assert error["light"] < error["interpolated"]


def test_light_fades_in_between_the_threshold_and_twice_of_it():
    steepness = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 9.0])
    assert surfaceness(steepness, 2.0).tolist() == [0.0, 0.0, 0.0, 0.5, 1.0, 1.0]
    assert surfaceness(steepness, 0.0).tolist() == [0.0, 1.0, 1.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize("share", [0.5, 0.75, 1.0, 2.0])
def test_weak_gradients_fade_on_the_device(renderer, share):
    """A ramp whose gradient is a share of twice the threshold."""
    ramp = np.broadcast_to(np.arange(12.0, dtype=np.float32)[:, None, None] * 2, (12, 12, 12))
    volume = al.Volume(np.ascontiguousarray(ramp))
    shade = al.shade.BlinnPhong(ambient=0.25, diffuse=0.5, specular=0, gradient_threshold=1 / share)
    tf = al.TransferFunction([(0, "white", 5.0)])
    camera = cameras(volume)["orthographic"]
    lights = [al.Light.directional(to_light=(0, 0, 1))]
    image = renderer.render(al.Scene(volume, transfer=tf, camera=camera, look=al.Look(shade=shade), lights=lights), SIZE)
    faded = min(max(2 * share - 1, 0), 1)
    inside = image.rgba[image.rgba[..., 3] > 0.999]
    assert inside[:, 0] == pytest.approx(0.25 + 0.5 * faded, abs=1e-3)
