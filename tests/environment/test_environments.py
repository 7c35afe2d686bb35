"""Environments as values: pictures, faces, files, turns, and the maps that are made of them."""

from __future__ import annotations

import io
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import airlight as al
from airlight.environment import maps, sphere
from airlight.environment.faces import FACES
from airlight.keeping import Kept
from airlight.reference import environment as truth

ANALYTIC = [al.Environment.studio(), al.Environment.sky(), al.Environment.white((0.2, 0.5, 1.0))]
DIRECTIONS = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1).map(lambda d: d / np.linalg.norm(d))


def octahedral_at(layer: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """What the device reads of a map: bilinear between texels, the outermost on the edge of the square."""
    n = len(layer)
    p = directions / np.abs(directions).sum(axis=1, keepdims=True)
    folded = (1 - np.abs(p[:, 1::-1])) * np.where(p[:, :2] >= 0, 1, -1)
    place = (np.where(p[:, 2:] >= 0, p[:, :2], folded) + 1) / 2 * (n - 1)
    column, row = np.clip(place.astype(int), 0, n - 2).T
    a, b = (place - np.stack([column, row], axis=1)).T[..., None]
    upper = layer[row, column] * (1 - a) + layer[row, column + 1] * a
    return upper * (1 - b) + (layer[row + 1, column] * (1 - a) + layer[row + 1, column + 1] * a) * b


def some_directions(count: int, rng: np.random.Generator) -> np.ndarray:
    found = rng.normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@pytest.fixture
def small_maps(monkeypatch):
    """Maps of few texels, kept apart from the whole ones."""
    for name, value in (("TEXELS", 9), ("ROWS", 8), ("LEAST_ROWS", 8), ("_KEPT", Kept(4))):
        monkeypatch.setattr(maps, name, value)


# -- pictures


def test_a_picture_lies_as_the_front_view_sees_it():
    """Zenith in the first row, +y in the middle, +x to the right of it; -y at both ends."""
    pixels = np.zeros((90, 180, 3))
    pixels[:, :, 0], pixels[:, :, 1] = np.arange(90)[:, None], np.arange(180)
    seen = truth.seen(
        al.Environment.from_picture(pixels), np.array([[0, 0, 1.0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, -1]])
    )
    assert np.allclose(seen[:, 0], [0, 44.5, 44.5, 44.5, 89])
    assert np.allclose(seen[1:4, 1], [89.5, 134.5, 44.5])


@pytest.mark.parametrize("face", FACES)
def test_faces_are_seen_from_inside(face):
    """A bright spot on one face, right of its middle and above it, is found there by its axes."""
    faces = {name: np.zeros((32, 32, 3)) for name in FACES}
    faces[face][6:10, 22:26] = 1.0
    environment = al.Environment.from_faces(faces)
    middle, right, up = (np.array(axis, dtype=float) for axis in FACES[face])
    assert truth.seen(environment, (middle + 0.5 * right + 0.5 * up)[None] / 1.2247)[0, 0] > 0.9
    assert truth.seen(environment, (middle - 0.5 * right + 0.5 * up)[None] / 1.2247)[0, 0] == 0.0
    assert np.array_equal(np.cross(right, up), -middle)  # right, up and towards the eye: nothing is mirrored


@pytest.mark.parametrize("environment", ANALYTIC, ids=lambda e: e.source.kind)
def test_equal_sources_share_their_maps(small_maps, environment):
    again = al.Environment.from_dict(environment.to_dict())
    assert again == environment
    assert hash(again) == hash(environment)
    assert maps.light_maps(again.source) is maps.light_maps(environment.turned(1.0).source)


def test_pictures_are_equal_by_content(small_maps, rng):
    pixels = rng.uniform(0, 2, (8, 16, 3))
    one, two = al.Environment.from_picture(pixels), al.Environment.from_picture(pixels.astype(np.float32))
    assert one == two
    assert one != al.Environment.from_picture(pixels * 2)
    assert maps.light_maps(one.source) is maps.light_maps(two.source)
    with pytest.raises(ValueError, match="read-only"):
        one.source.pixels[0, 0, 0] = 1


def test_the_sky_is_brightest_at_the_sun_and_lights_level_ground_to_white():
    to_sun = np.array([0.3, 0.8, 0.52]) / np.linalg.norm([0.3, 0.8, 0.52])
    sky = al.Environment.sky(to_sun=tuple(to_sun), turbidity=2.5)
    picture = np.asarray(sky.source.picture(), dtype=float)
    directions = sphere.pixel_directions(*picture.shape[:2])
    brightest = directions[np.unravel_index(picture.sum(axis=2).argmax(), picture.shape[:2])]
    assert brightest @ to_sun > np.cos(np.radians(2))
    up = truth.radiance(sky, np.array([[0, 0, 1.0]]), 1.0)[0]
    assert up @ [0.2126, 0.7152, 0.0722] == pytest.approx(1.0, rel=0.01)
    zenith, red_evening = picture[0].mean(axis=0), al.Environment.sky(to_sun=(0, 1, 0.05), sun=20).source.picture()
    assert zenith[2] > 1.5 * zenith[0]  # blue
    assert red_evening.max(axis=(0, 1))[0] > 2 * red_evening.max(axis=(0, 1))[2]


# -- files


@pytest.fixture
def pixels(rng):
    return rng.uniform(0, 5, (8, 16, 3)).astype(np.float32)


def test_npy_and_exr_load_equal(tmp_path, pixels):
    import OpenEXR

    np.save(tmp_path / "a.npy", pixels)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(tmp_path / "a.exr"))
    assert (
        al.Environment.open(tmp_path / "a.npy")
        == al.Environment.open(tmp_path / "a.exr")
        == al.Environment.from_picture(pixels)
    )


def test_hdr_loads_to_a_shared_exponents_precision(tmp_path, pixels):
    import imagecodecs

    (tmp_path / "a.hdr").write_bytes(imagecodecs.rgbe_encode(pixels, header=True))
    loaded = al.Environment.open(tmp_path / "a.hdr").source.pixels
    assert np.abs(loaded - pixels).max() <= 5 / 128


HEAD = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"
ARCHIVE = io.BytesIO()
np.savez(ARCHIVE, np.ones((2, 4, 3)))


def test_exposures_are_divided_out(tmp_path):
    """And a size in a comment is none."""
    pytest.importorskip("imagecodecs")
    head = HEAD + b"EXPOSURE=4\n# x\n-Y 90000 +X 90000\nEXPOSURE= 0.5\nCOLORCORR=1 2 4\n"
    (tmp_path / "a.hdr").write_bytes(head + b"\n-Y 2 +X 4\n" + b"\x80\x80\x80\x81" * 8)
    found = al.Environment.open(tmp_path / "a.hdr").source.pixels
    assert np.allclose(found, np.broadcast_to([0.5, 0.25, 0.125], (2, 4, 3)), rtol=0.01)


def test_untrusted_pictures_read_the_same(tmp_path, pixels):
    np.save(tmp_path / "a.npy", pixels)
    opened = al.Environment.open(tmp_path / "a.npy", untrusted=True)
    assert opened == al.Environment.open(tmp_path / "a.npy")
    for untrusted in (False, True):
        with pytest.raises(al.LimitError, match="at most 8"):
            al.Environment.open(tmp_path / "a.npy", untrusted=untrusted, max_memory=100)
    (tmp_path / "b.npy").write_bytes(b"hello")
    with pytest.raises(al.FileError, match="is no array"):
        al.Environment.open(tmp_path / "b.npy", untrusted=True)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.png", b"x", "is no picture of an environment"),
        ("missing.hdr", None, "cannot be read"),
        ("a.hdr", b"hello", "is no Radiance picture"),
        ("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 90000 +X 90000\n", "at most"),
        ("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n\2\2\0\x10", "is damaged"),
        ("a.exr", b"hello", "is no OpenEXR picture"),
        ("a.hdr", HEAD + b"\n-Y 2 +X 4\n\n-Y 2 +X 4\n" + b"\1\1\1\x80" * 4, "is damaged"),
        ("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 4\n" + b"\1\1\1\x80" * 8, "not RGB"),
        ("a.hdr", HEAD + b"EXPOSURE=0\n\n-Y 2 +X 4\n" + b"\1\1\1\x80" * 8, "header says 'EXPOSURE=0'"),
        ("a\0.hdr", None, "cannot be read"),
        ("a.npy", b"hello", "is no array"),
        ("a.npy", b"PK\3\4hello", "is no array"),
        ("a.npy", ARCHIVE.getvalue(), "is no array"),
    ],
)
def test_files_that_are_none_are_refused(tmp_path, name, content, words):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(al.AirlightError, match=words):
        al.Environment.open(tmp_path / name)


@pytest.mark.parametrize(("package", "ending", "extra"), [("imagecodecs", "hdr", "hdr"), ("OpenEXR", "exr", "exr")])
def test_a_missing_package_names_its_extra(tmp_path, monkeypatch, package, ending, extra):
    (tmp_path / f"a.{ending}").write_bytes(b"#?RADIANCE\n")
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(al.MissingExtraError, match=rf"airlight\[{extra}\]"):
        al.Environment.open(tmp_path / f"a.{ending}")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: al.Environment.from_picture(np.ones((8, 8, 3))), "twice as wide"),
        (lambda: al.Environment("studio"), "no source of light"),
        (lambda: al.Environment.open(None), "name a"),
        (lambda: al.Environment.studio().turned(1, ("a", "b", "c")), "finite number"),
        (lambda: al.Environment.from_faces([np.ones((4, 4, 3))]), "give a dict"),
        (lambda: al.Environment.from_faces({face: [[1], [2, 3]] for face in FACES}), "no array"),
        (lambda: al.Environment.from_picture([[1], [2, 3]]), "no array"),
        (lambda: al.Environment.from_picture(np.ones((8, 16))), "height, width, 3"),
        (lambda: al.Environment.from_picture(-np.ones((8, 16, 3))), "negative"),
        (lambda: al.Environment.from_picture(np.full((8, 16, 3), np.nan)), "no number"),
        (lambda: al.Environment.from_faces({"+x": np.ones((4, 4, 3))}), r"give \+x, -x"),
        (lambda: al.Environment.sky(to_sun=(0, 0, -1)), "at or above the horizon"),
        (lambda: al.Environment.sky(to_sun=("a", "b", "c")), "finite number"),
        (lambda: al.Environment.from_dict({"kind": "sky", "turn": 3}), "axis times radians"),
        (lambda: al.Environment.sky(turbidity=30), "must lie in"),
        (lambda: al.Environment.studio(key=-1), "must lie in"),
        (lambda: al.Environment.studio().turned(float("nan")), "finite"),
        (lambda: al.Environment.studio().turned(1.0, (0, 0, 0)), "finite direction"),
        (lambda: al.Environment.from_dict({"kind": "moon"}), "must be one of"),
        (lambda: al.Environment.from_dict({"kind": "sky", "sum": 1}), "no parameter of sky"),
        (lambda: al.shade.Environment("studio"), "pass an airlight.Environment"),
        (lambda: al.shade.Environment(roughness=1.5), "must lie in"),
    ],
)
def test_bad_values_are_refused(make, words):
    with pytest.raises(al.AirlightError, match=words):
        make()


# -- turns


@given(axis=DIRECTIONS, angle=st.floats(-7, 7), other=DIRECTIONS, more=st.floats(-7, 7), direction=DIRECTIONS)
def test_turns_follow_one_another(axis, angle, other, more, direction):
    def turn(axis, angle, d):
        return d * np.cos(angle) + np.cross(axis, d) * np.sin(angle) + axis * (axis @ d) * (1 - np.cos(angle))

    turned = al.Environment.studio().turned(angle, tuple(axis)).turned(more, tuple(other))
    moved = turn(other, more, turn(axis, angle, direction))
    assert np.allclose(turned.environment_from_world @ moved, direction, atol=1e-9)


def test_what_was_at_the_right_is_behind_after_a_quarter_turn():
    pixels = np.zeros((16, 32, 3))
    pixels[7:9, 23:25] = 1  # +x
    turned = al.Environment.from_picture(pixels).turned(np.pi / 2)
    assert truth.seen(turned, np.array([[0, 1.0, 0]]))[0, 0] > 0.9


# -- maps


def test_the_edge_of_a_map_is_folded_onto_itself():
    """Texels of an edge that are one direction are equal: no seam."""
    directions = sphere.octahedral_directions(33)
    for edge in (directions[0], directions[-1], directions[:, 0], directions[:, -1]):
        assert np.allclose(edge, edge[::-1])
    for layer in maps.light_maps(ANALYTIC[1].source):
        for edge in (layer[0], layer[-1], layer[:, 0], layer[:, -1]):
            assert np.allclose(edge, edge[::-1], rtol=1e-4, atol=1e-5)


@given(direction=DIRECTIONS, step=DIRECTIONS)
@settings(max_examples=200)
def test_interpolation_has_no_jumps(direction, step):
    """Two directions a millionth apart get nearly the same, also across the edges of the square."""
    near = direction + 1e-6 * step
    layer = maps.light_maps(ANALYTIC[0].source)[6].astype(np.float64)
    found = octahedral_at(layer, np.stack([direction, near / np.linalg.norm(near)]))
    assert np.abs(found[0] - found[1]).max() < 1e-4


@pytest.mark.parametrize("layer", range(1, maps.LAYERS))
def test_a_white_environment_is_white_in_all_maps(layer):
    assert np.abs(maps.light_maps(al.Environment.white().source)[layer] - 1).max() < 1e-6


@pytest.mark.parametrize("environment", ANALYTIC[:2], ids=lambda e: e.source.kind)
@pytest.mark.parametrize(("layer", "tolerance"), [(5, 0.03), (7, 0.01), (9, 0.01), (11, 0.01), (13, 0.005)])
def test_maps_are_the_sums_over_the_picture(environment, layer, tolerance, rng):
    """Against direct summation; relative to the greatest value of the map."""
    directions = some_directions(300, rng)
    stored = octahedral_at(maps.light_maps(environment.source)[layer].astype(np.float64), directions)[:, :3]
    exact = truth.radiance(environment, directions, maps.WIDTHS[layer - 1])
    assert np.abs(stored - exact).max() <= tolerance * exact.max()


def test_the_roughest_lobe_is_the_cosine(rng):
    """Irradiance over pi of a hemisphere of light, in closed form: (1 + cos) / 2."""
    pixels = np.zeros((256, 512, 3))
    pixels[:128] = 1
    directions = some_directions(200, rng)
    stored = octahedral_at(maps.light_maps(al.Environment.from_picture(pixels).source)[-1].astype(np.float64), directions)
    assert np.abs(stored[:, 0] - (1 + directions[:, 2]) / 2).max() < 2e-3


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.3, 0.6, 1.0])
@pytest.mark.parametrize("reflectance", [0.02, 0.04, 0.5, 1.0])
def test_what_a_coat_reflects(roughness, reflectance):
    """The table against Gauss' rule with another form of the masking; a perfect mirror by Schlick's formula."""
    cosines = np.linspace(0.03, 1, 40)
    n = maps.REFLECTION_TEXELS
    table = maps.reflection_table()[0].astype(np.float64)
    row, column = roughness * (n - 1), cosines * (n - 1)
    top, left = min(int(row), n - 2), np.minimum(column.astype(int), n - 2)
    b, a = row - top, (column - left)[:, None]
    shares = (table[top, left] * (1 - a) + table[top, left + 1] * a) * (1 - b)
    shares += (table[top + 1, left] * (1 - a) + table[top + 1, left + 1] * a) * b
    found = reflectance * shares[:, 0] + min(50 * reflectance, 1) * shares[:, 1]
    error = np.abs(found - truth.coat_albedo(cosines, roughness**2, reflectance, 96))
    assert error[cosines > 0.1].max() < 2e-3
    assert error.max() < 1e-2
    if roughness == 0:
        assert np.abs(found - reflectance - (1 - reflectance) * (1 - cosines) ** 5).max() < 2e-3


def test_between_layers_roughness_goes_by_the_logarithm_of_its_square():
    assert maps.layer_of(0) == 0
    assert maps.layer_of(1) == maps.LAYERS - 1
    assert maps.layer_of(0.5) == pytest.approx(9)  # alpha 1/4, four octaves above 1/64
    values = [maps.layer_of(r) for r in np.linspace(0, 1, 101)]
    assert (np.diff(values) > 0).all()


# -- pictures of other sizes


@given(rows=st.integers(1, 40), height=st.integers(2, 40))
def test_resizing_keeps_the_mean_of_smaller_pictures_and_constants(rows, height):
    rng = np.random.default_rng(height)
    picture = rng.uniform(0, 1, (height, 2 * height, 3))
    small = sphere.resized(picture, rows, 2 * rows)
    assert small.shape == (rows, 2 * rows, 3)
    if rows <= height:
        assert np.allclose(sphere.mean_of(small), sphere.mean_of(picture))
    assert np.allclose(sphere.resized(np.ones_like(picture), rows, 2 * rows), 1)
