"""``--normals`` and ``--disagreement``: files beside the picture."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from airlight.app import cli


def test_normals_are_written(tmp_path, volume_file):
    words = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--size", "24", "--integrate", "first_hit:iso=500"]
    for ending in ("npy", "png"):
        assert cli.main([*words, "--normals", str(tmp_path / f"n.{ending}")]) == 0
    normals, colours = np.load(tmp_path / "n.npy"), np.asarray(Image.open(tmp_path / "n.png"))
    met = normals.any(axis=-1)
    assert 0 < met.mean() < 1
    assert np.linalg.norm(normals[met], axis=-1) == pytest.approx(1, abs=1e-5)
    assert np.abs(colours[met] / 127.5 - 1 - normals[met]).max() < 0.01
    assert not colours[~met].any()


def test_normals_of_what_has_no_surfaces(tmp_path, volume_file, capsys):
    words = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--size", "24", "--integrate", "mip"]
    assert cli.main([*words, "--normals", str(tmp_path / "n.npy")]) == 2
    assert "first_hit" in capsys.readouterr().err
    assert cli.main([*words, "--normals", str(tmp_path / "n.jpg")]) == 2


@pytest.mark.parametrize(
    ("output", "normals", "words"),
    [
        ("a.png", "a.png", "is the file of the picture, too: name another"),
        ("a.png", "sub/../a.png", "is the file of the picture, too: name another"),
        ("a.png", "-", "cannot go to standard output: name a file"),
        ("a.png", "folder.png", "is a folder: name a file in it"),
        ("folder.png", "n.png", "is a folder: name a file in it"),
    ],
)
def test_normals_take_no_others_place(output, normals, words, tmp_path, volume_file, drawn, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "sub").mkdir()
    assert cli.main(["render", volume_file, "-o", output, "--integrate", "first_hit:iso=500", f"--normals={normals}"]) != 0
    assert words in capsys.readouterr().err
    assert not drawn


def test_the_disagreement_of_offsets_is_written(tmp_path, volume_file, capsys):
    words = ["render", volume_file, "-o", str(tmp_path / "a.png"), "--size", "24", "--step", "4", "--preset", "ct-bone"]
    for ending in ("npy", "png"):
        assert cli.main([*words, "--offsets", "interleaved", "--disagreement", str(tmp_path / f"d.{ending}")]) == 0
    assert np.load(tmp_path / "d.npy").shape == (24, 24)
    assert np.asarray(Image.open(tmp_path / "d.png")).shape == (24, 24, 3)
    for others in ([], ["--offsets", "blue_noise"]):
        assert cli.main([*words, *others, "--disagreement", str(tmp_path / "d.npy")]) == 2
        assert "--offsets interleaved" in capsys.readouterr().err
    stepping = [*words[:6], "--offsets", "interleaved", "--tolerance", "0.01"]
    assert cli.main([*stepping, "--disagreement", str(tmp_path / "d.npy")]) == 2
    assert "--tolerance chooses several" in capsys.readouterr().err
