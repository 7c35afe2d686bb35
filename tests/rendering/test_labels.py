"""Regions of labels against the float64 reference, and the laws that they keep."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SIZE, blobs, cameras, function, lights, rotation

import airlight as al
from airlight import reference
from airlight.gpu import textures
from airlight.rendering import resources

LEVEL = 1 / 255
GREATEST = 2**32 - 1
CLEAR = al.integrate.EmissionAbsorption(opaque_at=1.0)


def parcels(dtype="uint8", ids=(0, 1, 2, 3, 5, 8, 13), size=(32, 36, 40), seed=4) -> np.ndarray:
    """Cells round random points, each with one of the labels."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0, size, (24, 3))
    z, y, x = np.indices(size[::-1])
    distance = ((np.stack([x, y, z], axis=-1)[..., None, :] - points) ** 2).sum(axis=-1)
    return np.array(ids, dtype=dtype)[np.argmin(distance, axis=-1) % len(ids)]


def on_same_grid(array: np.ndarray) -> al.Volume:
    return al.Volume(array, world_from_index=blobs().world_from_index)


def on_other_grid(array: np.ndarray, scale=(0.6, 0.8, 0.5)) -> al.Volume:
    """A smaller box, turned and sheared against the image, whose middle is the image's."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation((1, -1, 2), 0.5) @ np.array([[1, 0.3, 0], [0, 1, -0.2], [0, 0, 1]]) * scale
    middle = blobs().corners_world().mean(axis=0)
    matrix[:3, 3] = middle - matrix[:3, :3] @ (np.array(array.shape[::-1]) - 1) / 2
    return al.Volume(array, world_from_index=matrix)


def scene(labels, camera="perspective", function_=None, **look) -> al.Scene:
    look = {"shade": "none", "integrate": CLEAR} | look
    layer = al.Layer(blobs(), function_ or function(), al.Look(**look), labels)
    return al.Scene(layers=[layer], camera=cameras(blobs())[camera], lights=lights(), background=None)


def draw(renderer, labels, **options):
    return renderer.render(scene(labels, **options), SIZE).rgba


def compare(renderer, drawn: al.Scene, tolerance=LEVEL) -> np.ndarray:
    image, truth = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    assert np.abs(image.rgba - truth.rgba).max() <= tolerance
    met = np.isfinite(truth.depth) & np.isfinite(image.depth)
    assert (np.isfinite(image.depth) == np.isfinite(truth.depth)).mean() > 0.999
    assert np.quantile(np.abs(image.depth[met] - truth.depth[met]), 0.98) < 0.05
    return image.rgba


def styled(volume: al.Volume) -> al.Labels:
    styles = {0: al.LabelStyle("white", 0.3), 1: "red", 2: al.LabelStyle((0.1, 0.9, 0.2), 0.1), 5: al.LabelStyle(opacity=0.6)}
    return al.Labels(volume, styles, hidden=[3])


@pytest.mark.parametrize("camera", ["perspective", "orthographic", "inside", "cut"])
@pytest.mark.parametrize("place", [on_same_grid, on_other_grid])
def test_parity(either_renderer, place, camera):
    compare(either_renderer, scene(styled(place(parcels())), camera))


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated", "preintegrated_fast"])
@pytest.mark.parametrize("shade", ["none", "blinn_phong"])
def test_parity_of_looks(either_renderer, transfer, shade):
    compare(either_renderer, scene(styled(on_other_grid(parcels())), transfer=transfer, shade=shade))


@pytest.mark.parametrize("field", ["linear_exact", "nearest"])
def test_parity_of_fields(renderer, field):
    drawn = scene(styled(on_same_grid(parcels())), field=field)
    image, truth = renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    # A sample on the border of two voxels may fall to either.
    assert error[: -max(1, error.size // 200)].max() <= LEVEL if field == "nearest" else error.max() <= LEVEL


@pytest.mark.parametrize("associated", [False, True])
def test_parity_of_thin_and_thick_functions(any_renderer, associated):
    """Where extinction is high a border is a surface; where it is low light gathers through several regions."""
    for factor in (0.05, 20.0):
        made = al.TransferFunction([(v, rgb, factor * tau) for v, rgb, tau in function().points], associated)
        compare(any_renderer, scene(styled(on_other_grid(parcels())), function_=made))


@pytest.mark.parametrize("dtype", ["bool", "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64"])
def test_integers_of_all_types(any_renderer, dtype):
    """With the least and the greatest label that a type holds."""
    low, high = (0, 1) if dtype == "bool" else (np.iinfo(dtype).min, np.iinfo(dtype).max)
    ids = (0, 1) if dtype == "bool" else (low, 0, 1, high - 1, high)
    styles = {low: al.LabelStyle("blue", 0.2), high: al.LabelStyle("red", 0.7)}
    labels = al.Labels(on_same_grid(parcels(dtype, ids)), styles)
    assert sorted(labels.ids().tolist()) == sorted(set(ids))
    compare(any_renderer, scene(labels))


@pytest.mark.parametrize("count", [2, 127, 128, 129, 32768, 32769])
def test_every_number_of_labels(renderer, count):
    """Also those at which the texture's format changes; labels are spread over 32 bits."""
    rng = np.random.default_rng(count)
    ids = np.append(np.unique(rng.integers(1, GREATEST, 2 * count, dtype=np.uint32))[: count - 2], np.uint32([0, GREATEST]))
    array = ids[rng.permutation(40 * 36 * 32) % count].reshape(40, 36, 32)
    assert len(np.unique(array)) == count
    drawn = scene(al.Labels(on_same_grid(array), {GREATEST: "red"}))
    compare(renderer, drawn)
    (told,) = renderer.render(drawn, (2, 2)).stats["layers"]
    assert told["textures"][1]["format"] == f"r{8 if count <= 128 else 16 if count <= 32768 else 32}uint"


@pytest.mark.parametrize("camera", ["perspective", "cut"])
@pytest.mark.parametrize("place", [on_same_grid, on_other_grid])
def test_parity_of_surfaces(either_renderer, place, camera):
    """What is hidden, or less than half opaque, is cut away; what lies behind it is seen."""
    labels = al.Labels(
        place(parcels()), {1: "red", 2: al.LabelStyle("lime", 0.4), 5: al.LabelStyle(opacity=0.6)}, hidden=[3, 8]
    )
    drawn = scene(labels, camera, integrate=al.integrate.FirstHit(iso=70.0), shade="blinn_phong")
    image, truth = either_renderer.render(drawn, SIZE), reference.render(drawn, SIZE)
    error = np.sort(np.abs(image.rgba - truth.rgba).max(axis=-1).ravel())
    assert error[: -(error.size // 200)].max() <= LEVEL  # at the very edge of a region a ray may meet it or not
    both = np.isfinite(image.depth) & np.isfinite(truth.depth)
    assert np.quantile(np.abs(image.depth[both] - truth.depth[both]), 0.98) < 0.05
    uncut = either_renderer.render(scene(None, camera, integrate=al.integrate.FirstHit(iso=70.0)), SIZE)
    assert (image.depth[both] > uncut.depth[both] + 1).mean() > 0.02


# -- laws


def test_one_white_label_everywhere_is_no_label(any_renderer):
    plain = draw(any_renderer, None, shade="blinn_phong")
    labels = al.Labels(on_same_grid(np.full((40, 36, 32), 7)), {7: "white"})
    assert np.array_equal(draw(any_renderer, labels, shade="blinn_phong"), plain)


def test_background_is_the_image(renderer):
    """Outside of the labels' box, and where they say so."""
    far = al.Volume(np.full((4, 4, 4), 3, dtype=np.uint8), origin=(1e4, 0, 0))
    assert np.array_equal(draw(renderer, al.Labels(far)), draw(renderer, None))
    assert not draw(renderer, al.Labels(far).hide(0)).any()


def test_all_hidden_is_empty(any_renderer):
    labels = al.Labels(on_other_grid(parcels()))
    image = any_renderer.render(scene(labels.hide(labels.ids()), shade="blinn_phong"), SIZE)
    assert not image.rgba.any()
    assert np.isinf(image.depth).all()


def test_permuting_labels_and_styles_together_changes_nothing(renderer):
    array = parcels()
    styles = {n: al.LabelStyle((n / 13, 1 - n / 13, 0.5), 1 / (1 + n)) for n in np.unique(array).tolist()}
    one = draw(renderer, al.Labels(on_same_grid(array), styles))
    other = {0: GREATEST, 1: 13, 2: 7, 3: 10**6, 5: 0, 8: 1, 13: 2}
    moved = np.vectorize(other.get)(array).astype(np.uint32)
    labels = al.Labels(on_same_grid(moved), {other[n]: style for n, style in styles.items()}, background=GREATEST)
    assert np.array_equal(draw(renderer, labels), one)


def test_no_label_is_ever_between_two(renderer):
    """Between 1 and 3 there is nothing of 2, and in front of its own region neither."""
    array = np.full((40, 36, 32), 1, dtype=np.uint8)
    array[:, :, 16:] = 3
    array[0, 0, 0] = 2  # so that it has a style on the device
    base = al.Labels(on_same_grid(array), {1: "red", 3: "blue"})
    green, none = draw(renderer, base.with_style(2, colour="lime")), draw(renderer, base.hide(2))
    differs = np.abs(green - none).max(axis=-1) > 0
    assert differs.sum() < 20  # the single voxel
    seen = draw(renderer, base.with_style(2, "black"))
    mixed = seen[..., :3][~differs & (seen[..., 3] > 0.5)]
    assert not mixed[:, 1].any()  # red and blue, and what lies between, has no green
    assert ((mixed[:, 0] > 0.02) & (mixed[:, 2] > 0.02)).any()


def test_borders_are_smooth(renderer):
    """A border that is slanted against the grid: what is seen of it follows the plane within a fraction of a voxel."""
    z, _, x = np.indices((32, 32, 32))
    array = (x + 0.37 * z > 21).astype(np.uint8)
    fog = al.Volume(np.full((32, 32, 32), 1.0, dtype=np.float32))
    tf = al.TransferFunction([(0, "white", 5.0), (2, "white", 5.0)])
    labels = al.Labels(al.Volume(array), {0: "red", 1: "lime"})
    camera = al.Camera.orthographic(eye=(15.5, -40, 15.5), target=(15.5, 15.5, 15.5), height=24)
    made = al.Scene(layers=[al.Layer(fog, tf, al.Look(shade="none"), labels)], camera=camera)
    image = renderer.render(made, (240, 240)).rgba
    # Along each row of pixels the border is where red and green are equal.
    share = image[..., 1] / (image[..., 0] + image[..., 1])
    at = np.array([np.interp(0.5, row, np.arange(240)) for row in share]) / 10 + 3.5
    z_of_row = 27.45 - np.arange(240) / 10
    away = at - (21.5 - 0.37 * z_of_row)
    assert np.abs(away - away.mean()).max() < 0.5  # nearest voxels are off by up to a whole one
    assert np.abs(np.diff(at)).max() < 0.25  # rows are a tenth of a voxel apart, and there is no jump of a whole one
    assert ((share > 0.05) & (share < 0.95)).mean() > 0.02


def test_hiding_and_skipping_agree(renderer):
    labels = styled(on_other_grid(parcels())).hide([0, 8])
    made = scene(labels, shade="blinn_phong")
    one, other = renderer.render(made, SIZE, skip="auto").rgba, renderer.render(made, SIZE, skip="none").rgba
    assert np.abs(one - other).max() <= 1e-4


def test_styles_change_a_table_and_nothing_else(monkeypatch):
    """Grid, labels and program stay on the device."""
    sent, made = [], []
    labels = styled(on_other_grid(parcels()))
    with al.Renderer() as own:
        before = draw(own, labels)
        for module, name in ((textures, "upload_grid"), (resources, "upload_labels"), (textures, "upload_table")):
            original = getattr(module, name)
            monkeypatch.setattr(module, name, lambda *a, o=original, n=name: sent.append(n) or o(*a))
        compiled = resources.compute._compile
        monkeypatch.setattr(resources.compute, "_compile", lambda *a: made.append(a) or compiled(*a))
        changed = [
            labels.hide([0, 1]),
            labels.show(),
            labels.only([5]),
            labels.highlight(8),
            labels.with_style([1, 2], "teal", opacity=0.4),
        ]
        images = [draw(own, other) for other in changed]
    assert sent == ["upload_table"] * len(changed)
    assert not made
    assert all(np.abs(image - before).max() > LEVEL for image in images)


def test_highlighted_labels_stand_out(renderer):
    labels = al.Labels(on_same_grid(parcels()), {8: "red"}, fade=0.0).highlight(8)
    alone = al.Labels(on_same_grid(parcels()), {8: "red"}).only(8)
    assert np.array_equal(draw(renderer, labels), draw(renderer, alone))
    assert np.array_equal(draw(renderer, labels.highlight(())), draw(renderer, al.Labels(on_same_grid(parcels()), {8: "red"})))


def test_time_steps_of_labels(renderer):
    first, second = parcels(seed=1), parcels(seed=2)
    image = al.Volume(np.stack([blobs().array] * 2)[:, None], world_from_index=blobs().world_from_index)
    both = al.Volume(np.stack([first, second])[:, None], world_from_index=blobs().world_from_index)

    def at(time, labels):
        layer = al.Layer(image, function(), al.Look(shade="none", integrate=CLEAR), labels, time=time)
        return renderer.render(al.Scene(layers=[layer], camera=cameras(blobs())["perspective"], background=None), SIZE).rgba

    assert np.array_equal(at(0, al.Labels(both)), at(1, al.Labels(on_same_grid(first))))
    assert np.array_equal(at(1, al.Labels(both)), at(0, al.Labels(on_same_grid(second))))


def test_far_from_the_origin(renderer):
    """The place of labels is found relative to the image: no digit is lost a million voxels away."""
    shift = np.eye(4)
    shift[:3, 3] = (3e6, -2e6, 1e6)
    labels = on_other_grid(parcels())
    moved = al.Volume(labels.array, world_from_index=shift @ labels.world_from_index)
    image = al.Volume(blobs().array, world_from_index=shift @ blobs().world_from_index)
    camera = cameras(blobs())["orthographic"]
    there = {name: tuple(np.array(getattr(camera, name)) + shift[:3, 3]) for name in ("eye", "target")}
    layer = al.Layer(image, function(), al.Look(shade="none", integrate=CLEAR), al.Labels(moved, {1: "red"}, hidden=[3]))
    far = al.Scene(layers=[layer], camera=al.Camera.orthographic(**there, height=camera.height), background=None)
    near = scene(al.Labels(labels, {1: "red"}, hidden=[3]), "orthographic")
    assert np.abs(renderer.render(far, SIZE).rgba - renderer.render(near, SIZE).rgba).max() <= LEVEL


def test_projections_of_values_have_no_regions(renderer):
    for integrate in ("mip", "minip", "mean"):
        with pytest.raises(al.StageError, match="emission_absorption"):
            draw(renderer, al.Labels(on_same_grid(parcels())), integrate=integrate)


# -- functions of regions


def own_functions() -> dict[int, al.LabelStyle]:
    steep = al.TransferFunction([(30, (1, 1, 0), 0), (50, (0, 1, 1), 0.8), (50, (1, 0, 1), 0.1), (90, "white", 2.0)])
    plain = al.TransferFunction([(60, "white", 0), (61, "white", 0.7)])
    return {
        0: al.LabelStyle("white", 0.4),
        1: al.LabelStyle(transfer=steep),
        2: al.LabelStyle("orange", 0.6, plain),
        5: al.LabelStyle("teal", 0.8, steep),
    }


@pytest.mark.parametrize("transfer", ["postclassified", "preintegrated", "preintegrated_fast"])
@pytest.mark.parametrize("place", [on_same_grid, on_other_grid])
def test_parity_of_functions_of_regions(either_renderer, place, transfer):
    labels = al.Labels(place(parcels()), own_functions(), hidden=[3])
    image = compare(either_renderer, scene(labels, transfer=transfer))
    lit = compare(either_renderer, scene(labels, "cut", transfer=transfer, shade="blinn_phong"))
    assert np.abs(image - draw(either_renderer, al.Labels(place(parcels()), hidden=[3]))).max() > 0.1
    assert lit.any()


def test_parity_of_associated_functions_of_regions(any_renderer):
    glow = al.TransferFunction([(40, (0, 0, 0), 0), (70, (0.02, 0.01, 0), 0), (110, (0.1, 0, 0.05), 0.4)], associated=True)
    dim = al.TransferFunction([(30, (0, 0.01, 0), 0), (90, (0, 0.05, 0.05), 0.1)], associated=True)
    labels = al.Labels(on_other_grid(parcels()), {1: al.LabelStyle(transfer=dim), 2: "red"}, default="white")
    for transfer in ("postclassified", "preintegrated"):
        compare(any_renderer, scene(labels, function_=glow, transfer=transfer))


def test_the_same_function_everywhere_is_the_layers(any_renderer):
    """One function as the layer's, or as that of some regions, or of all."""
    everywhere = al.Labels(on_other_grid(parcels()), default=al.LabelStyle("white"))
    some = everywhere.with_style([1, 2], transfer=function())
    for transfer in ("postclassified", "preintegrated_fast"):
        plain = draw(any_renderer, None, transfer=transfer)
        assert np.abs(draw(any_renderer, some, transfer=transfer) - plain).max() < 1e-4


def test_density_multiplies_functions_of_regions(renderer):
    labels = al.Labels(on_other_grid(parcels()), own_functions())
    scaled = {n: al.LabelStyle(s.colour, s.opacity, s.transfer and s.transfer.scaled(2.5)) for n, s in own_functions().items()}
    camera = cameras(blobs())["perspective"]

    def image(density, tf, styles):
        layer = al.Layer(blobs(), tf, al.Look(shade="none"), al.Labels(labels.volume, styles), density=density)
        return renderer.render(al.Scene(layers=[layer], camera=camera, background=None), SIZE)

    once, dense = image(1.0, function(), own_functions()), image(2.5, function(), own_functions())
    assert np.array_equal(dense.rgba, image(1.0, function().scaled(2.5), scaled).rgba)
    for what in ("a slab", "a slab's end"):
        known = [
            image.stats["layers"][0]["errors"][f"transfer: colour of {what}, its medium spread evenly"]
            for image in (once, dense)
        ]
        assert 0 < known[0] < known[1] < 1


def test_functions_that_do_not_go_together(renderer):
    own = al.Labels(on_same_grid(parcels()), {1: function()})
    glowing = al.TransferFunction(function().points, associated=True)
    for labels, options, what in (
        (own, {"integrate": al.integrate.FirstHit(iso=70)}, "emission_absorption"),
        (own, {"function_": glowing}, "of one kind"),
        (al.Labels(on_same_grid(parcels(ids=range(20))), {n: function().scaled(1 + n) for n in range(20)}), {}, "at most 15"),
    ):
        with pytest.raises(al.AirlightError, match=what):
            draw(renderer, labels, **options)


# -- labels without an image


def alone(styles=None, camera="perspective", transfer=None, size=(32, 36, 40), **look) -> al.Scene:
    volume = on_same_grid(parcels(ids=(0, 0, 0, 1, 2, 5, 2**8 - 1), size=size))
    labels = al.Labels(volume, styles or {1: "red", 2: al.LabelStyle((0.1, 0.9, 0.2), 0.2)}, hidden=[0])
    layer = al.Layer(volume, transfer or al.TransferFunction([(0.2, "white", 0), (0.8, "white", 0.6)]), al.Look(**look), labels)
    return al.Scene(layers=[layer], camera=cameras(blobs())[camera], lights=lights(), background=None)


@pytest.mark.parametrize("camera", ["perspective", "cut"])
@pytest.mark.parametrize("shade", ["none", "blinn_phong"])
def test_parity_without_an_image(either_renderer, camera, shade):
    compare(either_renderer, alone(camera=camera, shade=shade, integrate=CLEAR))


def test_labels_without_an_image_are_drawn_by_default(renderer):
    """A solid surface halfway between the region and the background, whatever the numbers of labels."""
    for label in (1, GREATEST):
        array = np.zeros((24, 24, 24), dtype=np.uint32)
        array[6:18, 6:18, 6:18] = label
        volume = al.Volume(array)
        made = al.Scene(layers=[al.Layer(volume, labels=al.Labels(volume, {label: "red"}))], camera="front")
        camera = al.Camera.orthographic(eye=(11.5, -40, 11.5), target=(11.5, 11.5, 11.5), height=24)
        image = renderer.render(al.Scene(layers=made.layers, camera=camera), (96, 96))
        seen = image.rgba[..., 3] > 0.5
        assert abs(seen.sum() - (12 * 4) ** 2) < 4 * 12 * 4  # twelve voxels wide and high
        assert np.abs(image.depth[40:56, 40:56] - (40 + 5.5)).max() < 0.3
        middle = image.rgba[40:56, 40:56]
        assert middle[..., 0].min() > 0.2  # lit, from the front
        assert not middle[..., 1:3].max() > 0.5 * middle[..., 0].min()
        assert made.layers[0].labels.hidden == {0}


def test_what_does_not_go_without_an_image(renderer):
    with pytest.raises(al.StageError, match="central or sobel"):
        renderer.render(alone(gradient="precomputed"), SIZE)
    with pytest.raises(al.StageError, match="no image"):
        renderer.render(alone({1: function()}), SIZE)
