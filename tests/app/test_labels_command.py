"""Labels on the command line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import airlight as al
from airlight import api
from airlight.app import cli
from airlight.app.labels import LabelOptions, label_notes, parse_labels, with_labels
from airlight.app.render import notes


@pytest.fixture
def folder(tmp_path, monkeypatch):
    array = np.arange(27, dtype=np.int16).reshape(3, 3, 3) % 5
    al.save(al.Volume(array, modality="labels"), tmp_path / "atlas.nii.gz")
    (tmp_path / "atlas.txt").write_text("1 liver 255 0 0\n2 spleen\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def layer(**options) -> al.Layer:
    return al.Layer(np.zeros((3, 3, 3), dtype=np.uint8), **options)


def test_labels_and_what_is_shown(folder):
    options = LabelOptions(labels="atlas.nii.gz", label_names="atlas.txt", hide_labels="0, liver,4")
    labels = with_labels(layer(), options).labels
    assert labels.hidden == {0, 1, 4}
    assert labels.style_of(1) == al.LabelStyle("red")
    alone = with_labels(layer(), replace(options, hide_labels=None, only_labels="spleen,3-9")).labels
    assert alone.hidden == {0, 1}
    bright = with_labels(layer(labels=labels), LabelOptions(highlight_labels="liver")).labels
    assert bright.highlighted == {1}
    assert bright.hidden == labels.hidden


def test_nothing_asked_is_nothing_changed():
    one = layer()
    assert with_labels(one, LabelOptions()) is one


def test_what_is_wrong_is_told(folder):
    with pytest.raises(al.ValueRangeError, match=r"--only-labels is given, but there are no labels: .*--labels FILE"):
        with_labels(layer(), LabelOptions(only_labels="3"))
    with pytest.raises(al.ValueRangeError, match="is it 'liver'"):
        with_labels(layer(), LabelOptions("atlas.nii.gz", "atlas.txt", hide_labels="livr"))
    with pytest.raises(al.FileError):
        with_labels(layer(), LabelOptions("missing.nii.gz"))


def test_numbers_ranges_and_names():
    labels = al.Labels(np.zeros((2, 2, 2), dtype=np.uint8), names={7: "left-sided", 8: "3rd"})
    assert parse_labels("1-3,left-sided,-4,3rd", labels) == {1, 2, 3, 7, -4, 8}
    with pytest.raises(al.ValueRangeError, match=r"--hide-labels have no '4th': see names"):
        with_labels(layer(labels=labels), LabelOptions(hide_labels="4th"))
    nameless = layer(labels=al.Labels(labels.volume))
    with pytest.raises(al.ValueRangeError, match=r"--only-labels have no '0-x': give numbers and ranges.*--label-names"):
        with_labels(nameless, LabelOptions(only_labels="0-x"))
    with pytest.raises(al.ValueRangeError, match=r"labels have no 'x': they have no names: give numbers"):
        nameless.labels.hide("x")


def test_the_image_itself_is_read_once(folder):
    image = al.Layer(al.open("atlas.nii.gz"))
    assert with_labels(image, LabelOptions("atlas.nii.gz")).labels.volume is image.volume


def test_labels_are_held_to_the_memory(folder):
    with pytest.raises(al.AirlightError, match="max_memory"):
        with_labels(layer(), LabelOptions("atlas.nii.gz"), max_memory=10)


def test_labels_that_do_not_occur_are_noted(folder):
    def told(**options):
        options = LabelOptions("atlas.nii.gz", "atlas.txt", **options)
        return list(label_notes(with_labels(layer(), options), options))

    assert told(hide_labels="0,liver,3-90") == told() == []
    assert told(hide_labels="0,4444", only_labels="-7-0,5-9", highlight_labels="1, -3") == [
        "--hide-labels 4444: no voxel has this label; they run from 0 to 4",
        "--only-labels 5-9: no voxel has this label; they run from 0 to 4",
        "--highlight-labels -3: no voxel has this label; they run from 0 to 4",
    ]
    assert list(label_notes(layer(), LabelOptions(hide_labels="3"))) == []


def test_an_image_in_the_place_of_labels_is_noted(folder):
    rng = np.random.default_rng(5)
    z, y, x = np.indices((20, 20, 20))
    ct = np.rint(40 * x + 20 * y - 900 + rng.normal(0, 12, x.shape)).astype(np.int16)
    cells = (1 + x // 4 + 5 * (y // 4) + 25 * (z // 4)).astype(np.int16)
    for name, array in (("ct", ct), ("cells", cells)):
        al.save(al.Volume(array), f"{name}.nrrd")

    def told(name):
        options = LabelOptions(f"{name}.nrrd")
        return list(label_notes(with_labels(layer(), options), options))

    assert told("cells") == []
    (note,) = told("ct")
    assert "ct.nrrd was taken as labels, and looks like an image" in note
    assert f"{len(np.unique(ct)) + (0 not in ct):,} different values from {ct.min()} to {ct.max()}" in note


def test_labels_beside_the_image_are_noted():
    def told(x: float) -> list[str]:
        labels = al.Volume(np.ones((3, 3, 3), dtype=np.uint8), origin=(x, 0, 0))
        one = al.Layer(al.Volume(np.zeros((3, 3, 3), dtype=np.uint8)), labels=labels)
        image = al.Image(np.ones((1, 1, 4), np.float32), np.ones((1, 1), np.float32))
        return list(notes(al.Scene(layers=[one]), image, chosen=False))

    assert told(2.9) == []
    assert [note for note in told(3.1) if "labels lie outside of the image" in note]


def test_notes_go_to_standard_error(folder, monkeypatch, capsys):
    image = al.Image(np.ones((2, 2, 4), np.float32), np.ones((2, 2), np.float32), (0, 0, 0), {})
    monkeypatch.setattr(api, "render", lambda *args, **options: image)
    monkeypatch.setattr(api, "warm_up", lambda device=None: None)
    words = ["render", "atlas.nii.gz", "-o", "a.png", "--labels", "atlas.nii.gz", "--hide-labels", "0,4444"]
    assert cli.main(words) == 0
    told = capsys.readouterr().err
    assert "note: --hide-labels 4444: no voxel has this label; they run from 0 to 4\n" in told
