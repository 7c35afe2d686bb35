"""Scenes save and load back equal; what is wrong in a file is named with file, line and key."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import airlight.io
from airlight import scene_file, stages
from airlight.environment import Environment
from airlight.errors import AirlightError, DataError, FileError, ValueRangeError
from airlight.labels import Labels, LabelStyle
from airlight.scene import VIEWS, Camera, Layer, Light, Look, Scene
from airlight.scene_file import reading
from airlight.scene_file.options import SKIP
from airlight.scene_file.table import Table
from airlight.scene_file.values import _alternatives
from airlight.stage import STAGES, Stage, stage_fields
from airlight.transfer import Channel, Channels, TransferFunction
from airlight.transfer.joint import JointFunction
from airlight.transfer.joint_axes import Axis
from airlight.transfer.joint_shapes import Box, Triangle
from airlight.volume import Source, Volume

FOLDER = Path("/somewhere/data")


def make_volume(path: str, **recipe: Any) -> Volume:
    options = tuple((k, " ".join(map(str, v)) if isinstance(v, tuple) else str(v).lower()) for k, v in recipe.items() if v)
    rest = tuple((k, v) for k, v in options if k not in ("dataset", "level"))
    source = Source(path, dataset=recipe.get("dataset", ""), level=recipe.get("level", 0), options=rest)
    array = np.arange(48, dtype=np.uint8).reshape(2, 2, 2, 2, 3)
    return Volume(array, channel_names=("red", "green"), source=source)


def make_labels(path: str) -> Volume:
    return Volume(np.arange(8, dtype=np.uint32).reshape(2, 2, 2), source=Source(path))


@pytest.fixture(autouse=True)
def opened(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> list[str]:
    """Replace ``open`` by one that needs no file; returns the paths that were asked for."""
    paths: list[str] = []
    if "real_io" in request.keywords:
        return paths

    def fake_open(path: str, *, untrusted: bool = False, progress: Any = None, max_memory: int = 0, **recipe: Any) -> Volume:
        paths.append(str(path))
        return make_labels(str(path)) if Path(path).stem == "labels" else make_volume(str(path), **recipe)

    monkeypatch.setattr(airlight.io, "open", fake_open, raising=False)
    return paths


# -- strategies

finite = st.floats(-1e6, 1e6)
vectors = st.tuples(finite, finite, finite)
colours = st.tuples(*[st.floats(0, 16)] * 3)
environments = st.builds(
    lambda made, angle, axis: made.turned(angle, axis) if any(axis) else made,
    st.one_of(
        st.builds(Environment.white, colours),
        st.builds(Environment.studio, key=st.floats(0, 100), rim=st.floats(0, 100)),
        st.builds(Environment.sky, to_sun=st.tuples(*[st.floats(0.1, 1)] * 3), turbidity=st.floats(2, 9), ground=colours),
    ),
    st.floats(-10, 10),
    st.tuples(*[st.floats(-1, 1)] * 3),
)


@st.composite
def values_of(draw: st.DrawFn, bounds: Any, hint: Any) -> Any:
    if bounds.choices:
        return draw(st.sampled_from(bounds.choices))
    kinds = _alternatives(hint)
    if type(None) in kinds and draw(st.booleans()):
        return None
    kind = next(k for k in kinds if k is not type(None))
    if kind is Environment:
        return draw(environments)
    if isinstance(kind, type) and issubclass(kind, Stage):
        return draw(stages_of(kind.slot))
    if kind is bool:
        return draw(st.booleans())
    if kind is int:
        return draw(st.integers(int(bounds.at_least or 0), int(64 if bounds.up_to is None else min(bounds.up_to, 64))))
    if kind is str:
        return draw(st.text("abc", min_size=1))
    low = bounds.above if bounds.above is not None else bounds.at_least
    high = bounds.below if bounds.below is not None else bounds.up_to
    number = st.floats(-1e6 if low is None else low, 1e6 if high is None else high)
    if kind is float:
        return draw(number.filter(bounds.allows))
    return draw(st.tuples(*[number] * len(get_args(kind))).filter(bounds.allows))


# Samples of kernels must make a filter.
KERNELS: dict[type[Stage], list[Stage]] = {
    stages.field.Kernel: [stages.field.Kernel(), stages.field.Kernel((0.0, 1.0, 0.0), 1)],
    stages.field.KernelBody: [
        stages.field.KernelBody(),
        stages.field.KernelBody.of(lambda x, y, z: 1 / (1 + x * x + y * y + z * z), 1),
    ],
}


@st.composite
def stages_of(draw: st.DrawFn, slot: str) -> Stage:
    cls = draw(st.sampled_from(sorted(STAGES[slot].values(), key=lambda c: c.name)))
    if cls in KERNELS:
        return draw(st.sampled_from(KERNELS[cls]))
    hints = get_type_hints(cls, include_extras=True)
    values = {f.name: draw(values_of(f.metadata["bounds"], hints[f.name])) for f in stage_fields(cls)}
    if cls is stages.lighting.Quantised and values["directions"] != "annealed":
        values["seed"] = 0  # another one would be refused
    if cls is stages.integrate.FirstHit:
        values["colours"] = draw(st.sampled_from(["viridis", "magma"]))
        values["normal"] = (1.0, 0.0, 0.5) if values["normal"] == (0, 0, 0) else values["normal"]
    return cls(**values)


@st.composite
def functions(draw: st.DrawFn) -> TransferFunction:
    values = sorted(draw(st.lists(finite, min_size=1, max_size=5)))
    points = [(v, draw(colours), draw(st.floats(0, 1e6))) for v in values]
    return TransferFunction(points, associated=draw(st.booleans()))


@st.composite
def mixtures(draw: st.DrawFn) -> Channels:
    names = draw(st.lists(st.sampled_from([0, 1, "red", "green"]), min_size=1, max_size=3, unique=True))
    associated = draw(st.booleans())
    found = [TransferFunction(draw(functions()).points, associated) for _ in names]
    parts = [Channel(name, tf, draw(st.booleans()), draw(st.floats(0, 1e3))) for name, tf in zip(names, found, strict=True)]
    return Channels(parts)


joints = st.builds(
    lambda colour, extinction, associated: JointFunction(
        [Axis("value", 0, 100), Axis("gradient", 0.0, 20.5)],
        [
            Box((10, 1), (50, 9), colour=colour, extinction=extinction),
            Triangle(40.0, 5.0, 20.0, 3.0, colour="lime", extinction=1),
        ],
        associated,
    ),
    colours,
    st.floats(0, 1e3),
    st.booleans(),
)


@st.composite
def lights(draw: st.DrawFn) -> Light:
    common: dict[str, Any] = {"color": draw(colours), "intensity": draw(st.floats(0, 1e3))}
    kind = draw(st.sampled_from(["head", "directional", "point"]))
    if kind == "head":
        return Light.head(**common)
    if kind == "point":
        radius = draw(st.none() | st.floats(1e-3, 1e3))
        return Light.point(position=draw(vectors), radius=radius, **common)
    to_light = draw(vectors.filter(lambda v: math.hypot(*v) > 1e-3))
    return Light.directional(to_light=to_light, **common)


@st.composite
def cameras(draw: st.DrawFn) -> Camera | str:
    if draw(st.booleans()):
        return draw(st.sampled_from(sorted(VIEWS)))
    eye, target = draw(vectors), draw(vectors)
    up = (0.0, 0.0, 1.0)
    try:
        if draw(st.booleans()):
            return Camera.perspective(eye=eye, target=target, up=up, fov_deg=draw(st.floats(1, 170)))
        return Camera.orthographic(eye=eye, target=target, up=up, height=draw(st.floats(1e-3, 1e3)))
    except ValueRangeError:
        return "front"


recipes = st.sampled_from(
    [
        {},
        {"dataset": "/a/b"},
        {"level": 2},
        {"shape": (3, 2, 2, 2, 2), "dtype": "uint8", "spacing": (0.1, 1.0, 2.5), "offset": 7, "big_endian": True},
    ]
)
volumes = st.builds(
    lambda name, recipe: make_volume(str(FOLDER / name), **recipe), st.sampled_from(["a.nrrd", "b.raw"]), recipes
)
label_styles = st.builds(LabelStyle, st.none() | colours, st.floats(0, 1), st.none() | functions())
ids = st.integers(-5, 2**32)


@st.composite
def labels(draw: st.DrawFn) -> Labels:
    return Labels(
        make_labels(str(FOLDER / "labels.nii")),
        draw(st.dictionaries(ids, label_styles, max_size=3)),
        draw(st.just(LabelStyle()) | label_styles),
        background=draw(st.integers(0, 3)),
        hidden=draw(st.sets(ids) | st.just(range(7, 90))),
        highlighted=draw(st.sets(ids)),
        fade=draw(st.floats(0, 1)),
        names=draw(st.dictionaries(ids, st.text("ab c", min_size=1), max_size=3)),
    )


looks = st.builds(Look, **{slot: stages_of(slot) for slot in Look.__dataclass_fields__})
layers = st.builds(
    Layer,
    volume=volumes,
    transfer=st.none() | functions() | mixtures() | joints,
    look=looks,
    labels=st.none() | labels(),
    visible=st.booleans(),
    density=st.floats(0, 1e3),
    channel=st.sampled_from([0, 1, "red", "green"]),
    time=st.sampled_from([0, 1]),
)
scenes = st.builds(
    Scene,
    layers=st.lists(layers, min_size=1, max_size=3),
    camera=cameras(),
    lights=st.lists(lights(), max_size=3),
    background=st.none() | colours | environments,
)


# -- round trips


@settings(max_examples=60, deadline=None)
@given(scene=scenes)
def test_scenes_load_back_equal(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "scene.toml"
    scene_file.save_scene(scene, path)
    loaded, options = scene_file.load_scene(path)
    assert loaded == scene
    assert options == {}


@given(
    size=st.tuples(st.integers(1, 4096), st.integers(1, 4096)),
    step=st.floats(0.01, 10),
    skip=st.sampled_from(SKIP),
    driver=st.just("march") | stages_of("driver"),
)
@settings(max_examples=20, deadline=None)
def test_render_table(size: Any, step: float, skip: str, driver: Any, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "render.toml"
    render = {"size": size, "step": step, "skip": skip, "driver": driver, "tolerance": 0.5}
    scene_file.save_scene(Scene(make_volume("/a.nrrd")), path, render=render)
    assert scene_file.load_scene(path)[1] == render


def test_paths_are_relative_to_the_file(tmp_path: Path, opened: list[str]) -> None:
    scene_file.save_scene(Scene(make_volume(str(tmp_path / "data" / "a.nrrd"))), tmp_path / "scene.toml")
    assert tomllib.loads((tmp_path / "scene.toml").read_text())["layers"][0]["volume"] == "data/a.nrrd"
    (tmp_path / "moved").mkdir()
    (tmp_path / "scene.toml").rename(tmp_path / "moved" / "scene.toml")
    scene_file.load_scene(tmp_path / "moved" / "scene.toml")
    assert opened == [str(tmp_path / "moved" / "data" / "a.nrrd")]


def test_one_file_is_one_volume(tmp_path: Path, opened: list[str]) -> None:
    volume = make_volume("/data/a.nrrd")
    scene_file.save_scene(Scene(layers=[Layer(volume), Layer(volume, channel=1)]), tmp_path / "scene.toml")
    scene, _ = scene_file.load_scene(tmp_path / "scene.toml")
    assert scene.layers[0].volume is scene.layers[1].volume
    assert opened == ["/data/a.nrrd"]


def test_a_volume_without_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Path] = []
    monkeypatch.setattr(airlight.io, "save", lambda volume, path: written.append(Path(path)), raising=False)
    first, second = Volume(np.zeros((2, 2, 2))), Volume(np.ones((2, 2, 2)))
    scene = Scene(layers=[Layer(first), Layer(second), Layer(first)])
    with pytest.raises(DataError, match=r"layers\[0\]\.volume came from no file: give embed"):
        scene_file.save_scene(scene, tmp_path / "scene.toml")
    assert not list(tmp_path.iterdir())
    scene_file.save_scene(scene, tmp_path / "scene.toml", embed=tmp_path / "kept.nrrd")
    assert written == [tmp_path / "kept.nrrd", tmp_path / "kept-2.nrrd"]
    assert [la["volume"] for la in tomllib.loads((tmp_path / "scene.toml").read_text())["layers"]] == [
        "kept.nrrd",
        "kept-2.nrrd",
        "kept.nrrd",
    ]


def test_written_by_hand(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(
        """
background = "#ff0000"
camera = { name = "perspective", eye = [0, -5, 0] }

[[lights]]
kind = "directional"
to_light = [0, 0, 2]

[[layers]]
volume = "head.nrrd"
transfer.points = [[0, "black", 0], [300, [1, 0.5, 0.25], 0.5]]
[layers.look]
shade = { name = "blinn_phong", ambient = 1, two_sided = false }
integrate = "mip"
""",
        encoding="utf-8",
    )
    scene, _ = scene_file.load_scene(path)
    assert scene.background == (1.0, 0.0, 0.0)
    assert scene.camera == Camera.perspective(eye=(0, -5, 0), target=(0, 0, 0))
    assert scene.lights == (Light.directional(to_light=(0, 0, 1)),)
    assert scene.layers[0].transfer == TransferFunction([(0, "black", 0), (300, (1, 0.5, 0.25), 0.5)])
    assert scene.layers[0].look == Look(
        shade=STAGES["shade"]["blinn_phong"](ambient=1.0, two_sided=False),  # type: ignore[call-arg]
        integrate="mip",
    )


# -- errors


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("colour = 3\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: colour is unknown: known here: annotations, background"),
        ("[[layers]]\nvolume='a.nrrd'\nalpha = 3", r"scene.toml:3: layers\[0\].alpha is unknown"),
        ("[[layers]]\nvolume='a.nrrd'\n[[layers]]\n\nvolume=3", r"scene.toml:5: layers\[1\].volume is 3, must be a table"),
        ("[[layers]]\ndensity = 1.0", r"layers\[0\].volume is missing"),
        ("[[layers]]\nvolume = {dataset='a'}", r"layers\[0\].volume.file is missing"),
        ("[[layers]]\nvolume='a.nrrd'\ndensity = -1", r"scene.toml:1: layers\[0\]: layer.density is -1.0, must be at least 0"),
        ("[[layers]]\nvolume='a.nrrd'\nvisible = 1", r"scene.toml:3: layers\[0\].visible is 1, must be true or false"),
        ("[[layers]]\nvolume='a.nrrd'\nchannel = 5", r"layers\[0\]: channel is 5, must lie in 0 to 1"),
        ("[[layers]]\nvolume='a.nrrd'\nlook.shade = 'x'", r"scene.toml:3: layers\[0\].look.shade: shade is 'x', .*--plugin"),
        (
            "[[layers]]\nvolume='a.nrrd'\n[layers.look]\nshade={name='blinn_phong', ambient=-1}",
            r"scene.toml:4: .*shade.blinn_phong.ambient is -1.0, must lie in \[0, inf\)",
        ),
        (
            "[[layers]]\nvolume='a.nrrd'\n[layers.look.shade]\nname='blinn_phong'\nambient='a'",
            r"scene.toml:3: .*shade.ambient is 'a', must be a number",
        ),
        ("[[layers]]\nvolume='a.nrrd'\nlook.shade={name='none', x=1}", r"shade.x is no parameter of none: it has no param"),
        ("[[layers]]\nvolume='a.nrrd'\nlook.shade={ambient=1}", r"must be a name or a table with a name"),
        ("[[layers]]\nvolume='a.nrrd'\nlook.shadow='none'", r"scene.toml:3: layers\[0\].look.shadow is unknown"),
        ("[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\npoints=[[1,2]]", r"scene.toml:4: .*transfer.points\[0\] is"),
        (
            "[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\npoints=[['a','red',0]]",
            r"scene.toml:4: .*points\[0\].value is 'a', must be a finite number",
        ),
        ("[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\npoints=3", r"scene.toml:4: .*points is 3"),
        ("[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\nchannels=3", r"scene.toml:4: .*channels is 3: .*list of tables"),
        (
            "[[layers]]\nvolume='a.nrrd'\n[[layers.transfer.channels]]\nchannel=0",
            r"scene.toml:3: layers\[0\].transfer.channels\[0\] has the entries \['channel'\]",
        ),
        (
            "[[layers]]\nvolume='a.nrrd'\n[[layers.transfer.channels]]\nchannel=0\ntransfer.points=[[1,'red',-1]]",
            r"scene.toml:5: layers\[0\].transfer.channels\[0\]: transfer.points\[0\].extinction is -1",
        ),
        (
            "[[layers]]\nvolume='a.nrrd'\n[[layers.transfer.channels]]\nchannel=0\ndensity=-1\ntransfer={points=[[1,'red',1]]}",
            r"scene.toml:4: layers\[0\].transfer.channels\[0\]: channel 0: density is -1",
        ),
        (
            "[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\naxes=[\n{variable='value', low=0, high=1},\n{low=0}]",
            r"scene.toml:6: layers\[0\].transfer.axes\[1\] axis has entries \['low'\]",
        ),
        (
            "[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\npoints=[[0,'red',1]]\nsurfaces=[\n{value=1},\n{value=2,opacity=3}]",
            r"scene.toml:7: layers\[0\].transfer.surfaces\[1\].opacity is 3",
        ),
        (
            "[[layers]]\nvolume='a.nrrd'\n[layers.transfer]\npoints=[]\naxes=[{variable='value'}]",
            r"layers\[0\].transfer.points is unknown: known here: associated, axes, shapes",
        ),
        ("camera='up'\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: camera is 'up', must be a table or one of front"),
        ("camera={name='perspective', fov_deg=200}\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: camera: .*fov_deg is 200"),
        ("[[lights]]\nkind='sun'\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:2: lights\[0\].kind is 'sun'"),
        ("[[lights]]\nkind='point'\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: lights\[0\].position is missing"),
        (
            "[[lights]]\nkind='head'\nradius=1\n[[layers]]\nvolume='a.nrrd'",
            r"scene.toml:3: lights\[0\].radius is no parameter of head: it has color",
        ),
        ("lights=3\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: lights is 3, must be a list of tables"),
        ("background=[1,2]\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: background is \[1, 2\], must be text or a list of 3"),
        ("[[layers]]\nvolume='a.nrrd'\n[render]\nsize=[0,1]", r"scene.toml:4: render.size is \(0, 1\)"),
        ("[[layers]]\nvolume='a.nrrd'\n[render]\nstep=nan", r"scene.toml:4: render.step is nan"),
        ("[[layers]]\nvolume='a.nrrd'\n[render]\nskip='all'", r"scene.toml:4: render.skip is 'all', must be one of auto"),
        ("[[layers]]\nvolume='a.nrrd'\n[render]\nplugin='x'", r"scene.toml:4: render.plugin is unknown"),
        (
            "[[layers]]\nvolume='a.nrrd'\n[render]\ndriver='x'",
            r"scene.toml:4: render.driver: driver is 'x', must be one of half_angle",
        ),
        ("format=2\n[[layers]]\nvolume='a.nrrd'", r"scene.toml:1: format is 2"),
        ("", r"scene.layers is empty"),
        ("[[layers]\n", r"scene.toml is no sound TOML \(.*line 1"),
    ],
)
def test_errors_name_file_line_and_key(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(AirlightError, match=message) as caught:
        scene_file.load_scene(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize(
    "text",
    ["background={file='FILE'}", "[layers.look.shade]\nname='environment'\nenvironment='FILE'"],
    ids=["background", "look"],
)
def test_pictures_of_untrusted_scenes(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are read in a process of its own, within the limit, and from the scene's folder alone."""
    path, inside, outside = tmp_path / "here" / "scene.toml", tmp_path / "here" / "a.npy", tmp_path / "a.npy"
    path.parent.mkdir()
    for file in (inside, outside):
        np.save(file, np.ones((4, 8, 3), np.float32))

    def load(file: str, **limits: Any) -> Scene:
        layer = "[[layers]]\nvolume='a.nrrd'\n"
        path.write_text((layer + text if text[0] == "[" else text + "\n" + layer).replace("FILE", file), encoding="utf-8")
        return scene_file.load_scene(path, **limits)[0]

    trusted = load("../a.npy")
    with pytest.raises(AirlightError, match="outside of the folder"):
        load("../a.npy", untrusted=True)
    with pytest.raises(AirlightError, match="at most 8 are"):
        load("a.npy", max_memory=100)

    def here(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr("airlight.environment.reading._read_npy", here)
    found = load("a.npy", untrusted=True)
    assert (found.background, found.layers[0].look.shade) == (trusted.background, trusted.layers[0].look.shade)


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read"):
        scene_file.load_scene(tmp_path / "none.toml")


@settings(max_examples=200, deadline=None)
@given(
    data=st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    [
                        "layers",
                        "volume",
                        "file",
                        "look",
                        "shade",
                        "name",
                        "transfer",
                        "points",
                        "camera",
                        "lights",
                        "kind",
                        "render",
                        "size",
                    ]
                ),
                inner,
                max_size=4,
            )
        ),
        max_leaves=20,
    )
)
def test_any_data_is_a_scene_or_a_clear_error(data: Any) -> None:
    root = Table(data if isinstance(data, dict) else {"layers": data}, (), "x.toml", "")
    original = reading.parsed
    reading.parsed = lambda path: root  # type: ignore[assignment]
    message = "x.toml"
    try:
        scene_file.load_scene("x.toml")
    except AirlightError as error:
        message = str(error)
    finally:
        reading.parsed = original
    assert message.startswith("x.toml")


def test_transfer_functions_in_files(tmp_path: Path) -> None:
    tf = TransferFunction([(0, "black", 0.0), (1, "white", 2.0)])
    (tmp_path / "tf.json").write_text('{"points": [[0, "black", 0], [1, "white", 2.0]]}')
    (tmp_path / "tf.toml").write_text('points = [[0, "black", 0], [1, "white", 2.0]]\n')
    assert scene_file.load_transfer(tmp_path / "tf.json") == tf
    assert scene_file.load_transfer(tmp_path / "tf.toml") == tf
    (tmp_path / "bad.json").write_text("[1]")
    with pytest.raises(FileError, match="must be a table"):
        scene_file.load_transfer(tmp_path / "bad.json")


@pytest.mark.parametrize(
    "load", [scene_file.load_scene, scene_file.load_transfer, TransferFunction.load, airlight.Channels.load]
)
def test_text_without_end_is_refused(load: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene file may come from anywhere, and may be a device that never ends."""
    path = tmp_path / "long.toml"
    path.write_text("# " + 100 * "x")
    monkeypatch.setattr("airlight.files.MOST_TEXT_BYTES", 101)
    with pytest.raises(airlight.LimitError, match=r"long.toml holds more than 101 bytes"):
        load(path)
    with pytest.raises(airlight.LimitError, match=r"long.toml would hold more than 101 bytes"):
        TransferFunction([(0, "red", 1)]).save(path)
    assert path.read_text() == "# " + 100 * "x"


def test_labels_by_hand(tmp_path: Path) -> None:
    """As a person writes them, and what they may get wrong."""
    path = tmp_path / "scene.toml"
    text = """[[layers]]
volume = "a.nrrd"
[layers.labels]
volume = "labels.nii"
hidden = "0,4-6"
styles.3 = { colour = "red", opacity = 0.5 }
names.3 = "liver"
"""
    path.write_text(text)
    found = scene_file.load_scene(path)[0].layers[0].labels
    assert found == Labels(
        make_labels(str(tmp_path / "labels.nii")), {3: LabelStyle("red", 0.5)}, hidden=[0, 4, 5, 6], names={3: "liver"}
    )
    for wrong, right, what in (
        ("hidden", "hiden", "unknown entries"),
        ('"0,4-6"', '"0,6-4"', "backwards"),
        ("styles.3 = {", "styles.4 = 5\nstyles.3 = {", "is 5, must be a table"),
        ('hidden = "0,4-6"', "hidden = 5", "labels.hidden is 5, must be a list"),
        ("opacity = 0.5", "opacity = 1.5", r"must lie in \[0, 1\]"),
        ("styles.3", "styles.three", "whole number"),
        ('"labels.nii"', '"image.nii"', "channels"),
    ):
        path.write_text(text.replace(wrong, right))
        with pytest.raises(airlight.AirlightError, match=what) as error:
            scene_file.load_scene(path)
        assert "scene.toml" in str(error.value)


def test_labels_that_are_no_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text("[[layers]]\nvolume = 'a.nrrd'\nlabels = 5\n")
    with pytest.raises(ValueRangeError, match=r"scene.toml:3: layers\[0\].labels is 5, must be a table"):
        scene_file.load_scene(path)


def test_numbers_of_numpy_are_saved(tmp_path: Path) -> None:
    function = TransferFunction([(0, "white", 1)])
    mixture = Channels([Channel(np.int64(0), function, density=np.float32(0.5))])  # type: ignore[arg-type]
    layer = Layer(make_volume("/data/a.nrrd"), mixture, channel=np.int64(0), time=np.int32(0), density=np.float32(2))  # type: ignore[arg-type]
    assert type(layer.channel) is int
    scene_file.save_scene(Scene(layers=[layer]), tmp_path / "scene.toml")
    assert scene_file.load_scene(tmp_path / "scene.toml")[0].layers[0] == layer


def test_plain_labels_are_a_file_name(tmp_path: Path) -> None:
    layer = Layer(make_volume("/data/a.nrrd"), labels=Labels(make_labels("/data/labels.nii")))
    scene_file.save_scene(Scene(layers=[layer]), tmp_path / "scene.toml")
    assert isinstance(tomllib.loads((tmp_path / "scene.toml").read_text())["layers"][0]["labels"], str)
    assert scene_file.load_scene(tmp_path / "scene.toml")[0].layers[0] == layer
