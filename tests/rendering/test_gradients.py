"""Gradients on the device: closed forms in sheared and anisotropic grids, textures of gradients in their formats."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from scenes import SIZE, blobs, rotation, scene

import airlight as al
from airlight import reference
from airlight.joint import Axis, Box
from airlight.reference.camera import CAMERAS
from airlight.stages.shade import Shade

LEVEL = 1 / 255
SHEAR = rotation((1, 2, 3), 0.7) @ np.array([[0.5, 0.2, 0.0], [0, 1.5, -0.3], [0, 0, 2.0]])
PRECOMPUTED = al.gradient.Precomputed
METHODS = ["central", "sobel", "precomputed", PRECOMPUTED("sobel"), PRECOMPUTED(with_value=True)]
FORMATS = [
    PRECOMPUTED(format="snorm8"),
    PRECOMPUTED("sobel", "snorm8", True),
    PRECOMPUTED("sobel", with_value=True),
    PRECOMPUTED("analytic", with_value=True),
]


@dataclass(frozen=True)
class ShowGradient(Shade):
    """The gradient as colour, around one half: gradients of up to half a unit of ``scale`` fit."""

    name: ClassVar[str] = "show_gradient"
    wgsl: ClassVar[str] = """
        import generated::show_gradient::params;
        import package::sample::{Sample, Lit};
        fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit {
          return Lit(here.gradient * params.scale + 0.5, vec3f(0.0));
        }
    """
    scale: al.F32 = al.param(1.0)


@dataclass(frozen=True)
class ShowNormal(Shade):
    """The normal as colour, around one half."""

    name: ClassVar[str] = "show_normal"
    wgsl: ClassVar[str] = """
        import package::sample::{Sample, Lit};
        fn light(here: Sample, normal: vec3f, to_eye: vec3f) -> Lit { return Lit(normal * 0.5 + 0.5, vec3f(0.0)); }
    """


def sheared(values, size=(14, 13, 12)) -> al.Volume:
    """Volume on a sheared, turned grid around the world's origin of a function of world points."""
    middle = (np.array(size) - 1) / 2
    x, y, z = np.meshgrid(*(np.arange(n) for n in size), indexing="ij")
    p_world = (np.stack([x, y, z], axis=-1) - middle) @ SHEAR.T
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = SHEAR, -SHEAR @ middle
    return al.Volume(values(p_world).transpose(2, 1, 0).astype(np.float32), world_from_index=matrix)


def hits(renderer, volume, iso, gradient, shade):
    """Points (n, 3) of a surface in the world that lie a voxel and more inside, and the colour (n, 3) there.

    Values rise along the rays.
    """
    camera = al.Camera.orthographic(eye=(-9, 14, -11), target=(0, 0, 0), height=12)
    look = al.Look(gradient=gradient, shade=shade, integrate=al.integrate.FirstHit(iso=iso))
    white = al.TransferFunction([(-1e3, (1, 1, 1), 1.0), (1e3, (1, 1, 1), 1.0)])
    image = renderer.render(al.Scene(volume, transfer=white, look=look, camera=camera, background=None), SIZE, step=0.25)
    y, x = np.nonzero(np.isfinite(image.depth))
    origin, direction = CAMERAS[camera.name](camera, SIZE, x, y)
    p_world = origin + image.depth[y, x, None] * direction
    p_index = p_world @ volume.index_from_world[:3, :3].T + volume.index_from_world[:3, 3]
    inside = ((p_index >= 1.01) & (p_index <= np.array(volume.size) - 2.01)).all(axis=1)
    assert inside.sum() > 50
    return p_world[inside], image.rgba[y, x, :3][inside]


@pytest.mark.parametrize("gradient", [*METHODS, "analytic", PRECOMPUTED(format="snorm8")], ids=str)
def test_gradients_of_a_linear_field_are_exact(any_renderer, gradient):
    g = np.array([0.4, -0.7, 0.3])
    volume = sheared(lambda p: p @ g)
    _, rgb = hits(any_renderer, volume, 0.1, gradient, ShowGradient(0.5))
    rounding = 0.2 * np.ptp(volume.array) / min(volume.spacing) / 254 if "snorm8" in str(gradient) else 0.0
    assert np.abs((rgb - 0.5) / 0.5 - g).max() < 1.01 * rounding + 2e-3


@pytest.mark.parametrize("gradient", METHODS, ids=str)
def test_gradients_of_a_quadratic_field_are_exact_away_from_the_faces(any_renderer, gradient):
    """Differences of a quadratic form are exact, and so is what is interpolated between voxels."""
    form = np.array([[0.3, 0.1, -0.05], [0.1, 0.2, 0.07], [-0.05, 0.07, 0.25]])
    volume = sheared(lambda p: -np.einsum("...i,ij,...j", p, form, p))
    p_world, rgb = hits(any_renderer, volume, -1.5, gradient, ShowGradient(0.1))
    found, expected = (rgb - 0.5) / 0.1, -2 * p_world @ form
    assert np.abs(expected).max() > 1
    assert np.abs(found - expected).max() < 0.02 * np.abs(expected).max()


@pytest.mark.parametrize("gradient", [*METHODS, PRECOMPUTED(format="snorm8", with_value=True)], ids=str)
def test_a_constant_field_has_none(any_renderer, gradient):
    """What is left is ambient light."""
    volume = sheared(lambda p: np.full(p.shape[:-1], 5.0))
    shade = al.shade.BlinnPhong(ambient=0.25, diffuse=1, specular=1)
    even = al.TransferFunction([(0, (1, 1, 1), 2.0), (10, (1, 1, 1), 2.0)])
    drawn = al.Scene(volume, transfer=even, look=al.Look(gradient=gradient, shade=shade), background=None)
    rgba = any_renderer.render(drawn, SIZE).rgba
    assert rgba[..., 3].max() > 0.9
    assert np.allclose(rgba[..., :3], 0.25 * rgba[..., 3:], atol=1e-4)


@pytest.mark.parametrize("gradient", ["precomputed", *FORMATS], ids=str)
def test_normals_have_unit_length_between_voxels(renderer, gradient):
    """Interpolated gradients are shorter where their directions part: a small sphere has many."""
    volume = sheared(lambda p: -np.linalg.norm(p, axis=-1))
    _, rgb = hits(renderer, volume, -2.0, gradient, ShowNormal())
    assert np.abs(np.linalg.norm(2 * rgb - 1, axis=1) - 1).max() < 1e-5


@pytest.mark.parametrize("camera", ["perspective", "inside"])
@pytest.mark.parametrize("gradient", FORMATS, ids=str)
def test_formats_follow_the_reference(either_renderer, gradient, camera):
    drawn = scene(gradient=gradient, camera=camera, lighting="interpolated")
    image, truth = either_renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.abs(image.rgba - truth.rgba).max() <= LEVEL
    told = image.stats["layers"][0]
    assert told["errors"]["gradient: component [data/world]"] > 0
    assert ("gradient: cut to [data/world]" in told["errors"]) == (gradient.format == "snorm8")
    assert ("field: value [data]" in told["errors"]) == gradient.with_value
    voxels = np.prod(blobs().size)
    (texture,) = told["voxels"].values()
    assert texture == {
        "format": "rgba16float" if gradient.format == "float16" else "rgba8snorm",
        "bytes": voxels * (8 if gradient.format == "float16" else 4),
    }


@pytest.mark.parametrize("dtype", ["uint8", "int16"])
def test_whole_numbers_are_exact_beside_their_gradients(renderer, dtype):
    drawn = scene(blobs(dtype), shade="blinn_phong", gradient=PRECOMPUTED(with_value=True))
    image = renderer.render(drawn, SIZE)
    assert image.stats["layers"][0]["errors"]["field: value [data]"] == 0
    apart = renderer.render(scene(blobs(dtype), gradient="precomputed"), SIZE)
    assert np.abs(image.rgba - apart.rgba).max() < LEVEL / 2


def test_strong_gradients_keep_their_direction(renderer):
    """Light asks for directions: those at a sharp surface are kept, though their lengths are cut."""
    z, y, x = np.mgrid[-10:11, -10:11, -10:11]
    sharp = 100 / (1 + np.exp(-3 * (6.3 - np.sqrt(x * x + y * y + z * z))))
    volume = al.Volume(sharp.astype(np.float32), origin=(-10, -10, -10))
    _, lengths = hits(renderer, volume, 50.0, "precomputed", ShowGradient(0.005))
    steepest = np.linalg.norm((lengths - 0.5) / 0.005, axis=1).max()
    image = renderer.render(scene(volume, gradient=PRECOMPUTED(format="snorm8")), SIZE)
    cut = image.stats["layers"][0]["errors"]["gradient: cut to [data/world]"]
    assert cut == pytest.approx(20, rel=1e-3)
    assert cut < 0.6 * steepest
    _, exact = hits(renderer, volume, 50.0, "precomputed", ShowNormal())
    _, rounded = hits(renderer, volume, 50.0, PRECOMPUTED(format="snorm8"), ShowNormal())
    angles_deg = np.degrees(np.arccos(np.clip(((2 * exact - 1) * (2 * rounded - 1)).sum(axis=1), -1, 1)))
    assert 0 < np.sqrt((angles_deg**2).mean()) < 3
    _, lengths = hits(renderer, volume, 50.0, PRECOMPUTED(format="snorm8"), ShowGradient(0.005))
    assert np.linalg.norm((lengths - 0.5) / 0.005, axis=1).max() < 1.02 * cut


def test_what_textures_cannot_hold_is_refused(renderer):
    def refused(**look):
        with pytest.raises(al.StageError) as caught:
            renderer.render(scene(look.pop("volume", None), **look), SIZE)
        return str(caught.value)

    holed = blobs().array.copy()
    holed[3, 3, 3] = np.nan
    empty = al.Volume(holed, world_from_index=blobs().world_from_index)
    assert "field linear" in refused(gradient=PRECOMPUTED(with_value=True), field="nearest")
    assert "without empty samples" in refused(gradient=PRECOMPUTED(with_value=True), volume=empty)
    joint = al.JointFunction([Axis("value", 0, 120), Axis("gradient", 0, 60)], [Box((30, 5), (90, 50), extinction=1)])
    base = scene(gradient=PRECOMPUTED(format="snorm8"))
    with pytest.raises(al.StageError, match="use float16"):
        renderer.render(replace_function(base, joint), SIZE)
    assert renderer.render(replace_function(scene(gradient=PRECOMPUTED(with_value=True)), joint), SIZE).rgba.any()


def replace_function(drawn: al.Scene, function) -> al.Scene:
    (layer,) = drawn.layers
    return al.Scene(layers=[replace(layer, transfer=function)], camera=drawn.camera, lights=drawn.lights, background=None)
