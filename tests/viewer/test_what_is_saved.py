"""What is saved of a view draws the same picture again: Python, scene files, pictures of any size."""

from __future__ import annotations

import ast
import dataclasses
import io
import json
import math
import threading
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

import airlight as al
from airlight.first_picture import resolve
from airlight.stage import STAGES
from airlight.viewer.asked import save
from airlight.viewer.bookmarks import added, keyframes
from airlight.viewer.document import Document
from airlight.viewer.script import scene_text, script
from airlight.viewer.session import Session, Viewer

SIZE_PX = (24, 20)
TF = al.TransferFunction([(0.1, "black", 0), (1, (1, 0.4, 0.1), 2)])


@pytest.fixture(scope="module")
def volume(tmp_path_factory: pytest.TempPathFactory) -> al.Volume:
    folder = tmp_path_factory.mktemp("Jane_Doe")
    z, y, x = np.mgrid[-1:1:10j, -1:1:10j, -1:1:10j]
    al.save(al.Volume(np.exp(-3 * (x * x + y * y + z * z)).astype(np.float32), name="Jane"), folder / "ball.nrrd")
    return al.open(folder / "ball.nrrd")


def run(text: str, volumes: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Run a script that opens these volumes; what it draws is not saved."""
    assert "Jane" not in text
    monkeypatch.setattr(al, "open", volumes.__getitem__, raising=False)
    names: dict[str, Any] = {}
    exec(compile(text.replace('image.save("picture.png")', ""), "script", "exec"), names)
    return names


def documents(volume: al.Volume) -> dict[str, Document]:
    camera = al.Camera.perspective(eye=(4, -30, 8), target=(4.5, 4.5, 4.5), fov_deg=25)
    plain = al.Scene(volume, transfer=TF, camera=camera)
    look = al.Look(
        field="bspline", shade=al.shade.BlinnPhong(ambient=0.3, shininess=7.5), tone=al.tone.Reinhard(key=0.2), integrate="mip"
    )
    channels = al.Channels([al.Channel(0, TF)])
    label = al.Labels(al.Volume((np.arange(1000).reshape(10, 10, 10) // 500).astype(np.uint8)))
    full = al.Scene(
        layers=[
            al.Layer(volume, TF, look, density=0.5, clips=[al.Clip.sphere(center=(4, 4, 4), radius=3.5)]),
            al.Layer(volume, al.TransferFunction.from_surfaces([al.Surface(0.5, "red", 0.4)]), visible=False),
        ],
        camera=al.Camera.orthographic(eye=(0, -20, 0), target=(0, 0, 0), height=12.5),
        lights=[al.Light.directional(to_light=(1, 2, 3), intensity=0.4), al.Light.point(position=(1, 2, 30), radius=4)],
        background=None,
        clips=[al.Clip.plane(point=(4, 4, 4), normal=(1, 0, 0), capped=True), al.Clip.box(low=(0, 0, 0), high=(8, 8, 8))],
        annotations=[al.ScaleBar(), al.Pointer((4, 4, 4), label="here")],
        meshes=[al.Lines([(0, 0, 0), (9, 9, 9)], color="blue")],
    )
    return {
        "plain": Document(plain),
        "full": Document(full, step=0.5, tolerance=None, skip="none", passes=(al.passes.BoundingBox(),)),
        "driver": Document(plain, driver=al.driver.March(offsets="interleaved"), tolerance=None),
        "environment": Document(al.Scene(volume, transfer=TF, camera=camera, background=al.Environment.named("studio"))),
        "mixture": Document(al.Scene(volume, transfer=channels, camera=camera)),
        "labels": Document(al.Scene(volume, transfer=TF, labels=label.hide({1}), camera=camera)),
    }


@pytest.mark.parametrize("name", ["plain", "full", "driver", "environment", "mixture", "labels"])
def test_the_script_makes_the_scene_again(volume: al.Volume, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    document, drawn = documents(volume)[name], []
    monkeypatch.setattr(al, "render", lambda scene, **options: drawn.append((scene, options)))
    text = script(document, SIZE_PX)
    labels = document.scene.layers[0].labels
    others = {} if labels is None else {"volume_2.nrrd": labels.volume}
    names = run(text, {"ball.nrrd": volume} | others, monkeypatch)
    assert names["scene"] == document.scene
    options = {"driver": "march", "step": 1.0, "skip": "auto", "passes": [], "tolerance": None} | drawn[0][1]
    assert options["size"] == SIZE_PX
    assert options["step"] == document.step
    assert max(map(len, text.splitlines())) < 160


@pytest.mark.parametrize(
    ("slot", "name"), [(slot, name) for slot in ("shade", "driver", "tone", "camera") for name in STAGES[slot]]
)
def test_every_stage_is_written(slot: str, name: str) -> None:
    from airlight.viewer.script import _stage

    needs = {"camera": {"eye": (0, -9, 1), "target": (0, 0, 0)}}
    try:
        stage = STAGES[slot][name](**needs.get(slot, {}))
    except TypeError:
        pytest.skip("needs more than comes by itself")
    made = eval(_stage(stage), {"al": al})
    assert made == (stage.name if isinstance(made, str) else stage)


def test_samples_and_volumes_without_files() -> None:
    vortex = Document(al.first_picture(al.samples.load("vortex", size=9)))
    assert "al.samples.load('vortex', size=9)" in script(vortex, SIZE_PX)
    array = Document(al.first_picture(al.Volume(np.random.default_rng(1).random((6, 6, 6), np.float32))))
    assert "al.save(volume" in script(array, SIZE_PX)
    for document in (vortex, array):
        with pytest.raises(al.DataError, match="Python script"):
            scene_text(document, SIZE_PX)


def test_keyframes_name_no_folders(tmp_path: Path) -> None:
    folder = tmp_path / "Jane_Doe"
    folder.mkdir()
    np.save(folder / "sky.npy", np.ones((4, 8, 3), np.float32))
    vortex = al.samples.load("vortex", size=6)
    al.save(vortex, folder / "ball.nrrd")
    al.save(al.Volume((vortex.array > 0.5).astype(np.uint8)), folder / "regions.nrrd")
    regions = al.Labels(al.open(folder / "regions.nrrd"), names={1: "inner"})
    scene = al.first_picture(al.open(folder / "ball.nrrd"))
    scene = dataclasses.replace(scene, layers=(dataclasses.replace(scene.layers[0], labels=regions),))
    document = Document(resolve(scene, SIZE_PX))
    hidden = dataclasses.replace(document.scene.layers[0], labels=regions.hide("inner"))
    sky = dataclasses.replace(document.scene, background=al.Environment.open(folder / "sky.npy"), layers=(hidden,))
    marks = added((), dataclasses.replace(document, scene=sky), "sky", whole=True)
    text = scene_text(document, SIZE_PX, keyframes(marks, document.scene, SIZE_PX))
    assert "Jane" not in text
    assert "beside ball.nrrd, regions.nrrd, sky.npy." in text
    path = folder / "scene.toml"
    path.write_text(text)
    again = al.movies.load_keyframes(path).of(al.load_scene(path)[0], SIZE_PX, folder).at(0)
    assert again.background == sky.background
    assert again.layers[0].labels is not None
    assert again.layers[0].labels.to_dict() == regions.hide("inner").to_dict()


def test_names_of_files_are_no_code(tmp_path: Path) -> None:
    path = tmp_path / "a\nraise SystemExit('ran')\n#.nrrd"
    al.save(al.samples.load("vortex", size=4), path)
    document = Document(al.first_picture(al.open(path)))
    assert not any(isinstance(node, ast.Raise) for node in ast.walk(ast.parse(script(document, SIZE_PX))))
    assert tomllib.loads(scene_text(document, SIZE_PX))["layers"][0]["volume"] == path.name


def test_the_scene_file_loads_beside_the_volume(volume: al.Volume, tmp_path: Path) -> None:
    document = documents(volume)["full"]
    text = scene_text(document, SIZE_PX)
    assert "Jane" not in text
    assert text.startswith("# To be put beside ball.nrrd")
    assert volume.source is not None
    (tmp_path / "ball.nrrd").write_bytes(Path(volume.source.path).read_bytes())
    (tmp_path / "scene.toml").write_text(text)
    scene, options = al.load_scene(tmp_path / "scene.toml")
    assert options["size"] == SIZE_PX
    assert options["step"] == 0.5
    assert scene.layers[0].transfer == document.scene.layers[0].transfer
    assert scene.camera == document.scene.camera


# -- pictures, with one device


@pytest.fixture(scope="module")
def session(volume: al.Volume) -> Any:
    with al.Renderer() as renderer:
        viewer = Viewer(
            Document(al.Scene(volume, transfer=TF, camera=documents(volume)["plain"].camera), tolerance=None), "", renderer
        )
        yield viewer.session()
        viewer.close()


def asked(session: Session, what: str, **arguments: Any) -> tuple[dict[str, Any], list[bytes]]:
    """Ask as a client does, and wait."""
    came, heard = threading.Event(), []

    def hear(message: dict[str, Any], buffers: list[bytes]) -> None:
        heard.append((message, buffers))
        came.set()

    session.receive({"type": "ask", "id": 1, "what": what, "arguments": arguments}, (), hear)
    assert came.wait(60)
    return heard[0]


def test_pictures_are_those_of_the_script(session: Session, volume: al.Volume, monkeypatch: pytest.MonkeyPatch) -> None:
    answer, (data,) = asked(session, "save.picture", size_px=list(SIZE_PX))
    assert answer["value"] == {"name": "picture.png", "kind": "image/png"}
    seen = np.asarray(Pillow.open(io.BytesIO(data)))
    assert seen.shape == (*SIZE_PX[::-1], 3)
    assert seen.max() > 60
    names = run(script(session.document, SIZE_PX), {"ball.nrrd": volume}, monkeypatch)
    assert np.array_equal(names["image"].picture(), seen)


def test_transparent_floats_and_depth(session: Session) -> None:
    _, (clear,) = asked(session, "save.picture", size_px=[12, 9], transparent=True, dither=True)
    assert Pillow.open(io.BytesIO(clear)).mode == "RGBA"
    _, (rgba,) = asked(session, "save.picture", kind="npy", size_px=[12, 9])
    _, (depth,) = asked(session, "save.picture", kind="npy", depth=True, size_px=[12, 9])
    assert np.load(io.BytesIO(rgba)).shape == (9, 12, 4)
    assert np.isfinite(np.load(io.BytesIO(depth))).any()
    pytest.importorskip("OpenEXR")
    _, (exr,) = asked(session, "save.picture", kind="exr", size_px=[12, 9], half=True)
    assert exr[:4] == b"\x76\x2f\x31\x01"


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "bmp"},
        {"size_px": [0, 5]},
        {"size_px": [1 << 20, 5]},
        {"size_px": [32000, 32000]},
        {"size_px": "x"},
        {"size_px": [3.5, 2]},
        {"kind": "exr", "dither": True},
        {"depth": True},
        {"path": "/tmp/x.png"},
    ],
)
def test_wrong_wishes(session: Session, wrong: dict[str, Any]) -> None:
    answer, buffers = asked(session, "save.picture", **wrong)
    assert set(answer["error"]) == {"where", "what", "remedy"}
    assert not buffers


def test_saving_is_cancelled_and_the_next_begins(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = threading.Event()
    whole: Callable[..., Any] = session.tell_progress
    monkeypatch.setattr(session, "tell_progress", lambda *told: (begun.set(), whole(*told)))
    monkeypatch.setattr(save, "POLL_S", 0.005)
    ended: list[Any] = []
    work = threading.Thread(target=lambda: ended.append(asked(session, "save.picture", size_px=[4000, 4000])))
    work.start()
    assert begun.wait(30)
    busy, _ = asked(session, "save.picture")
    assert "at work" in busy["error"]["what"]
    asked(session, "save.cancel")
    work.join(30)
    assert ended[0][0]["error"]["what"] == "was cancelled"
    assert "value" in asked(session, "save.picture", size_px=[4, 4])[0]


def test_movies_and_pages(session: Session) -> None:
    answer, (gif,) = asked(session, "save.movie", kind="gif", seconds=0.2, fps=10, size_px=[16, 12])
    assert answer["value"]["kind"] == "image/gif"
    assert gif[:4] == b"GIF8"
    assert "bookmark" in json.dumps(asked(session, "save.movie", way="bookmarks")[0]["error"])
    answer, (html,) = asked(session, "save.page", voxels=64, title="<b>")
    assert answer["value"]["name"] == "view.html"
    assert b"<b>" not in html
    assert b"Jane" not in html
    assert math.isfinite(len(html))
