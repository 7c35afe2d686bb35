"""Samples by name in the place of a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli
from airlight.errors import FileError, ValueRangeError


def run(*words: str) -> int:
    return cli.main(list(words))


def test_a_sample_is_drawn_told_and_counted_by_its_name(
    drawn: Drawn, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("render", "vortex", "-o", "a.png", "--preset", "xray") == 0
    (layer,) = drawn[0][0].layers
    assert layer.volume == al.samples.load("vortex")
    assert layer.transfer == al.presets.get("xray", layer.volume)
    assert run("info", "vortex") == 0
    assert "vortex\n  dimensions" in capsys.readouterr().out
    assert run("histogram", "vortex", "-o", "h.png") == 0
    assert (tmp_path / "h.png").stat().st_size > 1000


def test_a_file_of_this_name_always_wins(drawn: Drawn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    al.save(al.Volume(np.arange(27.0).reshape(3, 3, 3)), tmp_path / "ball.npy")
    (tmp_path / "ball.npy").rename(tmp_path / "vortex")
    assert run("render", "vortex", "-o", "a.png") == 0
    assert drawn[0][0].layers[0].volume.size == (3, 3, 3)


@pytest.mark.parametrize("broken", ["a link that leads nowhere", "a damaged file"])
def test_a_file_that_cannot_be_read_is_not_replaced_by_a_sample(
    broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if broken == "a damaged file":
        (tmp_path / "vortex").write_bytes(b"no volume at all")
    else:
        (tmp_path / "vortex").symlink_to("nowhere")
    assert run("info", "vortex") == 2
    assert "error: vortex" in capsys.readouterr().err


def test_near_names_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from airlight.app.inputs import open_named

    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    for name in ("vortices", "sub/vortices"):
        (tmp_path / name).touch()
    with pytest.raises(FileError, match=r"vortxes does not exist: is it vortices or the sample vortex\?"):
        open_named("vortxes")
    # Samples have no folder.
    with pytest.raises(FileError, match=r"sub/vortexes does not exist: is it sub/vortices\?"):
        open_named("sub/vortexes")
    for odd in ("", "zzz", "no/folder.nrrd"):
        with pytest.raises(FileError, match=r"does not exist: check the path"):
            open_named(odd)


def test_options_that_tell_how_to_read_do_not_go_with_samples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from airlight.app.inputs import open_named

    monkeypatch.chdir(tmp_path)
    assert run("info", "vortex", "--big-endian") == 2
    assert "--big-endian tells how to read a file, and vortex is a sample: leave it out" in capsys.readouterr().err
    with pytest.raises(ValueRangeError, match=r"--spacing"):
        open_named("vortex", spacing=(1.0, 1.0, 1.0))
    assert open_named("vortex", max_memory=1 << 30).size == al.samples.load("vortex").size
