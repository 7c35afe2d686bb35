"""Movies as files: colours, whole or not at all, and frames that are those of pictures drawn alone."""

from __future__ import annotations

import itertools
from concurrent.futures import Future
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

import airlight as al
from airlight.app import cli
from airlight.movies import Plan, Turntable, make_plan, making, targets
from airlight.movies.making import drawn, write_movie
from airlight.movies.pictures import write_apng, write_gif
from airlight.movies.targets import checked_target
from airlight.movies.video import write_video
from airlight.rendering import renderer as rendering
from airlight.rendering.image import Image

SIZE = (48, 32)
PATCHES = [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255), (0, 0, 0), (200, 120, 40), (30, 60, 220), (128, 128, 128)]


def patches(shift: int = 0) -> np.ndarray:
    """Picture of flat colours, each 16 by 16 pixels."""
    colours = np.array(PATCHES[shift:] + PATCHES[:shift], np.uint8).reshape(2, 4, 3)
    return colours.repeat(16, axis=0).repeat(16, axis=1)


def rgb_of(frame: Any) -> np.ndarray:
    """sRGB of a 4:2:0 frame of limited range, by the definition of BT.709."""
    height, width = frame.height, frame.width
    planes = [np.frombuffer(p, np.uint8).reshape(p.height, p.line_size)[:, : p.width].astype(float) for p in frame.planes]
    y, cb, cr = planes[0], *(plane.repeat(2, axis=0).repeat(2, axis=1)[:height, :width] for plane in planes[1:3])
    luma, blue, red = (y - 16) / 219, (cb - 128) / 224, (cr - 128) / 224
    r, b = luma + 2 * (1 - 0.2126) * red, luma + 2 * (1 - 0.0722) * blue
    return 255 * np.clip(np.stack([r, (luma - 0.2126 * r - 0.0722 * b) / 0.7152, b], axis=-1), 0, 1)


def decoded(path: Path) -> tuple[Any, list[Any]]:
    """Stream of a video, and its frames."""
    import av

    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        return stream.codec_context, [(frame, stream.average_rate) for frame in container.decode(stream)]


# -- colours


@pytest.mark.parametrize("ending", [".mp4", ".webm"])
def test_colours_are_those_of_bt709_and_the_tags_say_so(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"patches{ending}"
    write_video(path, iter([patches(0), patches(1), patches(1)]), checked_target(path, 24))
    codec, frames = decoded(path)
    assert len(frames) == 3
    assert (codec.colorspace, codec.color_primaries, codec.color_trc, codec.color_range) == (1, 1, 13, 1)
    assert codec.name == {".mp4": "h264", ".webm": "vp9"}[ending]
    for (frame, rate), asked in zip(frames, (patches(0), patches(1)), strict=False):
        assert rate == 24
        error = np.abs(rgb_of(frame) - asked).reshape(2, 16, 4, 16, 3)[:, 5:11, :, 5:11]
        assert error.max() <= 4, "in the middle of patches"


def test_quality_is_a_choice(tmp_path: Path, rng: np.random.Generator) -> None:
    noise = rng.integers(0, 255, (64, 64, 3), dtype=np.uint8)
    bytes_of = []
    for quality in (10, 80, 100):
        path = tmp_path / f"{quality}.mp4"
        write_video(path, iter([noise] * 3), checked_target(path, 29.97, quality))
        bytes_of.append(path.stat().st_size)
    assert bytes_of[0] < bytes_of[1] < bytes_of[2]
    assert decoded(tmp_path / "10.mp4")[1][0][1] == Fraction(2997, 100)


def test_webm_is_transparent(tmp_path: Path) -> None:
    import av

    path = tmp_path / "patches.webm"
    alpha = np.zeros((32, 64, 1), np.uint8)
    alpha[:, :32] = 200
    write_video(path, iter([np.concatenate([patches(), alpha], axis=-1)] * 2), checked_target(path))
    decoder = av.CodecContext.create("libvpx-vp9", "r")  # what players take for it, unlike the library's default
    with av.open(str(path)) as container:
        frames = [frame for packet in container.demux(video=0) for frame in decoder.decode(packet)]
    found = frames[0].to_ndarray(format="rgba")[..., 3]
    assert np.abs(found[8, [8, 24, 40, 56]].astype(int) - [200, 200, 0, 0]).max() <= 3


def test_gif_and_png_by_pillow(tmp_path: Path) -> None:
    given = [patches(0), patches(1), patches(2)]
    write_apng(tmp_path / "a.png", iter(given), checked_target(tmp_path / "a.png", 20))
    write_gif(tmp_path / "a.gif", iter(given), checked_target(tmp_path / "a.gif", 30))
    lasting_ms = []
    for name, worst in (("a.png", 0), ("a.gif", 2)):
        with Pillow.open(tmp_path / name) as file:
            assert file.n_frames == 3
            for number, asked in enumerate(given):
                file.seek(number)
                lasting_ms.append(file.info["duration"])
                assert np.abs(np.asarray(file.convert("RGB")).astype(int) - asked).max() <= worst
    assert lasting_ms == [50, 50, 50, 30, 40, 30], "in whole hundredths, the sum of which is right"


def test_a_picture_that_stays_too_long_is_told(tmp_path: Path) -> None:
    with pytest.raises(al.FileError, match=r"stays for too long: write \.mp4 or \.webm"):
        write_gif(tmp_path / "a.gif", iter([patches()] * 8), checked_target(tmp_path / "a.gif", 0.01))


# -- what can be written is known before anything is drawn


@pytest.mark.parametrize(
    ("name", "options", "told"),
    [
        ("a.avi", {}, "has no ending that says what to write"),
        ("none/a.mp4", {}, "its folder is not there"),
        ("a.mp4", {"size": (63, 64)}, "takes even numbers: use 64x64"),
        ("a.mp4", {"size": (20000, 64)}, "at most 16,384 pixels a side"),
        ("a.gif", {"fps": 60}, "must be at most 50 for .gif"),
        ("a.mp4", {"fps": 1e-5}, "fps is 1e-05, must be at least 0.01"),
        ("a.mp4", {"seconds": 1e308}, "would have inf frames, at most 1,000,000 are allowed"),
        ("a.mp4", {"keyframes": [(0, {}), (1e308, {})]}, "would have inf frames, at most 1,000,000 are allowed"),
        ("a.gif", {"quality": 60}, "quality is for .mp4 and .webm"),
        ("a.mp4", {"quality": 0}, r"whole number in \[1, 100\]"),
        ("a.gif", {"size": (8192, 8192), "seconds": 60}, "GiB of frames in memory"),
        ("frame-%04d.jpg", {}, "is no name of frames"),
        ("held", {}, r"has frames already \(frame-\*.png\)"),
        ("held/[a]-%d.png", {}, r"has frames already \(\[a\]-\*\.png\)"),
        ("a.mp4", {"background": None}, "write .webm or .png"),
    ],
)
def test_what_cannot_be_written_is_told_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, options: dict[str, Any], told: str
) -> None:
    monkeypatch.setattr(rendering, "shared", lambda device=None: None)
    (tmp_path / "held").mkdir()
    (tmp_path / "held" / "frame-0007.png").touch()
    (tmp_path / "held" / "[a]-7.png").touch()
    background = options.pop("background", "black")
    scene = al.Scene(np.zeros((4, 4, 4)), transfer=al.TransferFunction([(0, "red", 1)]), background=background)
    with pytest.raises(al.AirlightError, match=told):
        al.movie(scene, tmp_path / name, **{"size": SIZE, **options})


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(targets, "find_spec", lambda name: None)
    with pytest.raises(al.MissingExtraError, match=r'pip install "airlight\[movie\]", or write .gif or .png'):
        checked_target(tmp_path / "a.mp4")
    assert checked_target(tmp_path / "a.gif").kind == "gif"


# -- whole or not at all


class FakeRenderer:
    """Pictures of the number of their request; an error takes the place of one of them."""

    def __init__(self, failing: int = -1) -> None:
        self.asked: list[tuple[al.Scene, dict[str, Any]]] = []
        self.closed: set[Any] = set()
        self.failing = failing

    def submit(self, scene: al.Scene, size: tuple[int, int], **options: Any) -> Future[Image]:
        number = len(self.asked)
        self.asked.append((scene, options))
        future: Future[Image] = Future()
        if number == self.failing:
            future.set_exception(al.DeviceError("adapter", "is lost"))
            return future
        rgba = np.full((size[1], size[0], 4), min(number, 10) / 10, np.float32)
        stats = {"tolerance": {"pixels_over": int(number == 2)}}
        future.set_result(Image(rgba, rgba[..., 0], scene.background, stats))
        return future

    def close_view(self, view: object) -> None:
        self.closed.add(view)


@pytest.fixture
def plain_scene() -> al.Scene:
    return al.Scene(np.zeros((4, 4, 4)), transfer=al.TransferFunction([(0, "red", 1)]), camera="iso")


@pytest.mark.parametrize("name", ["a.mp4", "a.webm", "a.gif", "a.png", "frames", "f-%d.png"])
def test_what_is_interrupted_leaves_nothing(tmp_path: Path, plain_scene: al.Scene, name: str) -> None:
    class Interrupted(BaseException):
        pass

    def interrupt(what: str, done: int, total: int) -> None:
        if done == 3:
            raise Interrupted

    for renderer, progress, error in ((FakeRenderer(3), None, al.DeviceError), (FakeRenderer(), interrupt, Interrupted)):
        with pytest.raises(error):
            write_movie(plain_scene, checked_target(tmp_path / name), make_plan(frames=6), SIZE, renderer, {}, progress)
        assert list(tmp_path.iterdir()) == []
        assert renderer.closed == {options["view"] for _, options in renderer.asked}
        assert len(renderer.asked) <= 5, "one frame ahead"


def test_folders_and_names_of_frames(tmp_path: Path, plain_scene: al.Scene) -> None:
    for name, first in (("frames", "frames/frame-0001.png"), ("f-%03d.png", "f-001.png")):
        made = write_movie(plain_scene, checked_target(tmp_path / name), make_plan(frames=3), SIZE, FakeRenderer(), {})
        assert (made.frames, made.seconds, made.path) == (3, 0.1, tmp_path / name)
        assert made.notes == ("nothing is visible (1 of 3 frames)", "the tolerance was not reached everywhere (1 of 3 frames)")
        with Pillow.open(tmp_path / first) as file:
            assert file.size == SIZE
    assert len(list((tmp_path / "frames").iterdir())) == 3


def test_scenes_that_are_one_are_drawn_once(plain_scene: al.Scene) -> None:
    renderer, told = FakeRenderer(), []
    images = list(drawn(renderer, [plain_scene] * 3, SIZE, {}, lambda *report: told.append(report)))
    assert images[0] is images[1] is images[2]
    assert len(renderer.asked) == 1
    assert told == [(making.DRAWING, done, 3) for done in range(4)]


# -- by a renderer


def test_frames_are_those_of_pictures_drawn_alone(
    tmp_path: Path, renderer: al.Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rendering, "shared", lambda device=None: renderer)
    volume = al.samples.load("vortex", size=12)
    scene = al.Scene(volume, transfer=al.presets.glowing("turbo", volume), camera="iso", background="#203040")
    plan = Plan(Turntable(), frames=5)
    asked = {"turns": plan.turntable, "frames": 5, "size": SIZE}
    for name, quality in (("a.png", None), ("a.mp4", 100)):
        al.movie(scene, tmp_path / name, quality=quality, **asked)
    fitted = making.with_room_to_turn(scene, plan.turntable, SIZE)
    alone = [renderer.render(one, SIZE) for one in plan.scenes(fitted, SIZE, 30)]
    with Pillow.open(tmp_path / "a.png") as file:
        for number, image in enumerate(alone):
            file.seek(number)
            assert np.array_equal(np.asarray(file.convert("RGB")), image.picture())
    error = np.stack([rgb_of(frame) for frame, _ in decoded(tmp_path / "a.mp4")[1]]) - [image.picture() for image in alone]
    blocks = error.reshape(5, 16, 2, 24, 2, 3).mean(axis=(2, 4))  # colours have half the resolution
    assert np.abs(blocks).mean() < 3
    assert np.abs(error.mean(axis=(0, 1, 2))).max() < 1
    kept = {image.stats["kept"]["bytes"] for image in alone}
    assert len(kept) == 1, "nothing new lies on the device"
    for before, after in itertools.pairwise(alone):
        assert not np.array_equal(before.rgba, after.rgba)


# -- the command


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    renderer = FakeRenderer()
    monkeypatch.setattr(rendering, "shared", lambda device=None: renderer)
    monkeypatch.setattr("airlight.api.warm_up", lambda device=None: None)
    monkeypatch.chdir(tmp_path)
    al.save(al.samples.load("vortex", size=8), "v.nrrd")
    size = ["--size", "32x32"]
    turn = ["--turns", "-0.5", "--axis", "view", "--ease", "--frames", "3", "--driver", "slices", "--step", "2"]
    assert cli.main(["movie", "v.nrrd", "-o", "a.gif", *turn, *size]) == 0
    eyes = [np.array(scene.camera.eye) for scene, _ in renderer.asked]
    middle = np.array(renderer.asked[0][0].camera.target)
    assert eyes[2] - middle == pytest.approx(middle - eyes[0], abs=1e-6)
    assert [renderer.asked[0][1][name] for name in ("step", "driver")] == [2.0, al.driver.Slices()]
    assert "note: nothing is visible (1 of 3 frames)" in capsys.readouterr().err
    Path("tour.toml").write_text(
        'scene = "v.nrrd"\n[[keyframes]]\ntime_s = 0\n[[keyframes]]\ntime_s = 1\n"layers[0].density" = 0.5\n'
    )
    for words in (["tour.toml"], ["v.nrrd", "--keyframes", "tour.toml"]):
        renderer.asked.clear()
        assert cli.main(["movie", *words, "-o", "b.png", "--fps", "4", *size]) == 0
        assert [scene.layers[0].density for scene, _ in renderer.asked][::2] == [1, 0.75, 0.5]
    renderer.asked.clear()
    for words, told in (
        (["-o", "-"], "-o"),
        (["-o", "a.mp4", "--size", "31x32"], "use 32x32"),
        (["-o", "a.gif", "--keyframes", "tour.toml", "--turns", "1"], "is given beside keyframes"),
        (["-o", "a.gif", "--axis", "1,0"], "--axis"),
        (["-o", "a.gif", "--over", "time"], "several time steps"),
    ):
        assert cli.main(["movie", "v.nrrd", *words]) == 2
        assert told in capsys.readouterr().err
    assert not renderer.asked
