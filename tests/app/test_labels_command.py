"""Labels on the command line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import airlight as al
from airlight.app.labels import LabelOptions, parse_labels, with_labels


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


def test_the_image_itself_is_read_once(folder):
    image = al.Layer(al.open("atlas.nii.gz"))
    assert with_labels(image, LabelOptions("atlas.nii.gz")).labels.volume is image.volume


def test_labels_are_held_to_the_memory(folder):
    with pytest.raises(al.AirlightError, match="max_memory"):
        with_labels(layer(), LabelOptions("atlas.nii.gz"), max_memory=10)
