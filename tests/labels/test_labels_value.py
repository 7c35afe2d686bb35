"""Labels as a value: styles, sets, dense numbers, names from files, and text."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import airlight as al
from airlight.gpu.labels import label_cells
from airlight.labels import dense, label_numbers, styles_table
from airlight.labels.names import read_label_table
from airlight.labels.ranges import ids_to_text, text_to_ids
from airlight.labels.style import distinct_colours, vivid

TF = al.TransferFunction([(0, "white", 0), (1, "white", 1)])
DTYPES = ["bool", "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64"]


def volume(array=None) -> al.Volume:
    return al.Volume(np.array([0, 3, 3, 7, 9, 0, 7, 1], dtype=np.int16).reshape(2, 2, 2) if array is None else array)


def grids():
    shapes = st.tuples(*[st.integers(1, 6)] * 3)
    return st.sampled_from(DTYPES).flatmap(lambda dtype: arrays.arrays(dtype, shapes))


# -- dense numbers


@given(grids(), st.integers(0, 1))
def test_numbers_lead_back_to_labels(array, background):
    found = label_numbers(al.Volume(array), 0, background)
    whole = np.concatenate([part for _, part in found.slices()])
    assert np.array_equal(found.ids[whole], array)
    assert found.ids[0] == background
    assert (np.diff(found.ids[1:].astype(object)) > 0).all()
    assert set(found.ids.tolist()) == set(array.astype(object).ravel().tolist()) | {background} or array.dtype == bool


@given(grids(), st.lists(st.integers(-(2**64), 2**65), max_size=5))
def test_numbers_of_labels(array, others):
    found = label_numbers(al.Volume(array))
    wanted = [*found.ids.tolist(), *others]
    known = {label: number for number, label in enumerate(found.ids.tolist())}
    assert found.of(wanted).tolist() == [known.get(label, -1) for label in wanted]


@given(grids())
def test_searching_and_looking_up_agree(array):
    found = label_numbers(al.Volume(array))
    one = np.concatenate([part for _, part in found.slices()])
    limit, dense.MOST_LOOKED_UP = dense.MOST_LOOKED_UP, 0
    try:
        other = np.concatenate([part for _, part in found.slices()])
    finally:
        dense.MOST_LOOKED_UP = limit
    assert np.array_equal(one, other)


@given(grids(), st.integers(1, 40))
def test_cells_tell_where_labels_differ(array, chunk):
    """Whatever the chunks in which they are made."""
    limit, dense.CHUNK_VOXELS = dense.CHUNK_VOXELS, chunk
    try:
        found = label_numbers(al.Volume(array))
        parts = list(label_cells(found))
    finally:
        dense.CHUNK_VOXELS = limit
    cells = np.concatenate([part for _, part in parts])
    assert [z for z, _ in parts] == np.cumsum([0, *(len(part) for _, part in parts[:-1])]).tolist()
    padded = np.pad(array.astype(object), 1, constant_values=0)
    assert cells.shape == padded.shape
    assert np.array_equal(found.ids[cells >> 1].astype(object), padded)
    z, y, x = cells.shape
    for p in np.ndindex(z - 1, y - 1, x - 1):
        corner = padded[p[0] : p[0] + 2, p[1] : p[1] + 2, p[2] : p[2] + 2]
        assert (cells[p] & 1) == (len(set(corner.ravel().tolist())) > 1)


def test_numbers_are_found_once():
    v = volume()
    assert label_numbers(v) is label_numbers(v)
    assert label_numbers(v) is not label_numbers(v, background=3)


def test_hundreds_of_thousands_of_labels():
    rng = np.random.default_rng(0)
    ids = np.unique(rng.integers(0, 2**32 - 1, 400_000, dtype=np.uint32))
    array = ids[rng.permutation(np.arange(80**3) % len(ids))].reshape(80, 80, 80)
    labels = al.Labels(al.Volume(array), {int(ids[5]): "red"}, hidden=ids[::2].tolist())
    table = styles_table(labels).reshape(-1, 4)
    number = label_numbers(labels.volume, 0, 0).of([int(ids[5]), int(ids[4]), 0])
    assert np.array_equal(table[number[:2]], [(1, 0, 0, 1), (0, 0, 0, 0)])
    assert np.array_equal(table[0], (1, 1, 1, 1))
    assert (table[:, 3] > 0).sum() == len(labels.ids()) - len(set(ids[::2].tolist()))


# -- styles


def test_what_is_not_told():
    labels = al.Labels(volume())
    assert labels.style_of(0) == al.LabelStyle("white")
    assert labels.style_of(3).tint(3) == pytest.approx(tuple(distinct_colours([3])[0]))
    assert al.LabelStyle(transfer=TF).tint(3) == (1, 1, 1)
    assert labels.opacity_of(99) == 1


@given(st.lists(st.integers(0, 2**32 - 1), min_size=1, unique=True))
def test_colours_belong_to_labels(ids):
    """The same alone, among others, and in any type; light enough to be seen, and in range."""
    colours = distinct_colours(np.array(ids, dtype=np.uint32))
    assert np.array_equal(colours, distinct_colours(np.array(ids, dtype=np.int64)))
    assert np.array_equal(colours[:1], distinct_colours(ids[:1]))
    assert (colours <= 1).all()
    assert (colours >= 0).all()
    assert (colours.max(axis=1) > 0.3).all()


def test_neighbours_have_distinct_colours():
    colours = distinct_colours(np.arange(1, 120))
    distance = np.linalg.norm(colours[:, None] - colours, axis=-1) + 9 * np.eye(119)
    assert distance.min() > 0.01
    assert np.linalg.norm(np.diff(colours, axis=0), axis=1).min() > 0.15


def test_sets_of_labels():
    labels = al.Labels(volume(), names={3: "liver", 7: "spleen"})
    hidden = labels.hide(["liver", 9]).hide(1)
    assert hidden.hidden == {1, 3, 9}
    assert hidden.show(3).hidden == {1, 9}
    assert not hidden.show().hidden
    assert labels.only("spleen").hidden == {0, 1, 3, 9}
    assert labels.only([0, 7]).hidden == {1, 3, 9}
    bright = labels.highlight(7, fade=0.25)
    assert [bright.opacity_of(n) for n in (0, 3, 7)] == [0.25, 0.25, 1]
    assert len(set(bright.tint_of(3))) == 1
    assert bright.tint_of(7) == pytest.approx(vivid(np.array(labels.tint_of(7))))
    assert bright.highlight(()).opacity_of(3) == 1
    assert labels.name_of(3) == "liver"
    assert labels.name_of(9) == "9"
    assert labels == al.Labels(labels.volume, names={7: "spleen", 3: "liver"})
    assert hash(labels) == hash(al.Labels(labels.volume, names={7: "spleen", 3: "liver"}))


def test_what_is_highlighted_is_pure_and_bright_and_the_rest_all_but_clear():
    styles = {1: "#804040", 3: "white", 7: (0.2, 0.2, 0.2), 9: al.LabelStyle("black", transfer=TF)}
    bright = al.Labels(volume(), styles).highlight([1, 3, 7, 9])
    red, green, blue = bright.tint_of(1)
    assert red == 1
    assert green == blue < 0.1
    assert bright.tint_of(3) == bright.tint_of(7) == (1, 1, 1)  # grey has no hue
    assert bright.tint_of(9) == (0, 0, 0)
    assert bright.opacity_of(1) == 1
    # Through a head of optical depth 160, as the presets make it, nine tenths of what stands out in it are seen.
    assert np.exp(-160 * bright.opacity_of(0)) > 0.9
    # Order of the components, and so the hue, stays.
    colours = distinct_colours(np.arange(3000))
    pure = vivid(colours)
    assert np.array_equal(np.argsort(pure, axis=1), np.argsort(colours, axis=1))
    assert pure.max(axis=1) == pytest.approx(np.ones(3000))
    assert (pure.min(axis=1) < 0.15).all()


def test_changed_styles_keep_what_is_not_given():
    labels = al.Labels(volume(), {3: al.LabelStyle("red", 0.5)}).with_style(3, transfer=TF).with_style([7, 9], opacity=0.25)
    assert labels.style_of(3) == al.LabelStyle("red", 0.5, TF)
    assert labels.style_of(9) == al.LabelStyle(opacity=0.25)
    assert labels.with_style(3, "blue").style_of(3) == al.LabelStyle("blue")
    assert labels.functions == (TF,)


def test_the_table_is_what_styles_say():
    labels = al.Labels(volume(), {3: al.LabelStyle((0.5, 0.25, 0), 0.5, TF), 12: "red"}, default="lime", hidden=[7, 50])
    rows = {n: styles_table(labels).reshape(-1, 4)[k].tolist() for k, n in enumerate(labels.ids().tolist())}
    assert rows == {0: [1, 1, 1, 1], 1: [0, 1, 0, 1], 3: [0.25, 0.125, 0, 2.5], 7: [0, 0, 0, 0], 9: [0, 1, 0, 1]}
    for label in labels.highlight([3, 9]).ids().tolist():
        changed = labels.highlight([3, 9], fade=0.5)
        row = styles_table(changed).reshape(-1, 4)[label_numbers(labels.volume).of([label])[0]]
        opacity = changed.opacity_of(label)
        assert row[3] % 2 == pytest.approx(opacity)
        assert row[:3] == pytest.approx(np.array(changed.tint_of(label)) * opacity)


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: al.Labels(np.zeros((2, 2, 2), dtype=np.float32)), "are float32"),
        (lambda: al.Labels(np.zeros((2, 2, 2, 2), dtype=np.uint8)), "have 2 channels"),
        (lambda: al.Labels(volume(), {1.5: "red"}), "whole number"),
        (lambda: al.Labels(volume(), {1: "no colour"}), "no colour"),
        (lambda: al.LabelStyle(opacity=1.5), "must lie in"),
        (lambda: al.LabelStyle(transfer="red"), "give a TransferFunction"),
        (lambda: al.Labels(volume(), fade=2), "labels.fade"),
        (lambda: al.Labels(volume(), names={3: "liver"}).hide("livr"), "is it 'liver'"),
        (lambda: al.Labels(volume()).hide("liver"), "have no 'liver'"),
        (lambda: al.Labels(volume(), background=1 << 40).ids(), "no int16 is"),
        (lambda: al.Layer(volume(), labels=np.zeros((2, 2, 2))), "are float64"),
        (lambda: al.Layer(volume(), labels=al.Volume(np.zeros((2, 1, 2, 2, 2), dtype=np.uint8)), time=0), None),
        (lambda: al.Labels.from_dict(volume(), {"styles": {"3": {"color": "red"}}}), "unknown entries"),
        (lambda: al.Labels.from_dict(volume(), {"styles": {"3": "red"}}), "is 'red', must be a table"),
        (lambda: al.Labels.from_dict(volume(), {"styles": 5}), "labels.styles are 5, must be a table"),
        (lambda: al.Labels.from_dict(volume(), {"names": 5}), "labels.names are 5, must be a table"),
        (lambda: al.Labels.from_dict(volume(), {"hidden": 5}), "labels.hidden is 5, must be a list"),
        (lambda: al.Labels(volume(), ["red"]), "labels.styles are .*: give styles by label"),
        (lambda: al.Labels(volume(), hidden=3), "labels.hidden is 3, must be a list"),
        (lambda: al.Labels(volume()).only(None), "is None, must be a list: give numbers or names"),
        (lambda: al.Labels(volume()).hide("9" * 5000), "have no"),
        (lambda: al.Layer(volume(), labels="atlas.nii.gz"), "pass airlight.open"),
        (lambda: al.Layer(volume(), [TF, "red"]), "transfer.channel 1 has a str"),
        (lambda: al.Layer(volume(), time=0.5), "layer.time is 0.5, must be a whole number"),
        (lambda: al.Layer(volume(), channel=True), "layer.channel is True"),
        (lambda: al.Layer(volume(), density="1"), "layer.density is '1'"),
    ],
)
def test_what_is_wrong_is_told(make, what):
    if what is None:
        make()
        return
    with pytest.raises(al.AirlightError, match=what):
        make()


# -- text


@given(st.frozensets(st.integers(-20, 20) | st.integers(0, 2**64)))
def test_text_of_labels_reads_back(ids):
    assert text_to_ids(ids_to_text(ids)) == ids


@pytest.mark.parametrize(
    ("text", "ids"), [("3,5-9", {3, 5, 6, 7, 8, 9}), (" 1 , 1 ,", {1}), ("-3--1, 4 - 5", {-3, -2, -1, 4, 5}), ("", set())]
)
def test_text_of_labels(text, ids):
    assert text_to_ids(text) == ids


@pytest.mark.parametrize("text", ["a", "3-", "9-5", "1.5", "0-4294967295", "1-2-3"])
def test_wrong_text_of_labels(text):
    with pytest.raises(al.ValueRangeError):
        text_to_ids(text)


def test_tables_of_names(tmp_path):
    path = tmp_path / "names.txt"
    path.write_text(
        "# No. Label Name: R G B A\n"
        "0 Unknown 0 0 0 0\n"
        "2   Left-Cerebral-White-Matter     245 245 245 0\n"
        "1 Precentral_L 2001\n"
        '17   10  20   30        1  1  1    "Left hippocampus, head"\n'
        "5,two words,255,0,0,0\n"
        "\n"
        "7 9\n",
        encoding="utf-8",
    )
    table = read_label_table(path)
    names = {
        0: "Unknown",
        2: "Left-Cerebral-White-Matter",
        1: "Precentral_L",
        17: "Left hippocampus, head",
        5: "two words",
        7: "9",
    }
    assert table.names == names
    assert set(table.colours) == {0, 2, 5, 17}
    assert table.colours[5] == (1, 0, 0)
    assert table.colours[17] == al.LabelStyle("#0a141e").colour
    labels = table.applied_to(al.Labels(volume(), {5: "blue"}, names={3: "kept"}))
    assert dict(labels.names) == names | {3: "kept"}
    assert labels.style_of(5) == al.LabelStyle("blue")
    assert labels.style_of(2).colour == table.colours[2]
    path.write_text("nothing here\n")
    for wrong in (path, tmp_path / "missing.txt"):
        with pytest.raises(al.FileError):
            read_label_table(wrong)


@pytest.mark.parametrize(
    ("line", "name", "colour"),
    [
        ("2 Area 4", "Area 4", None),
        ("2 Area 4 255 0 0", "Area 4", (1, 0, 0)),
        ("2 Area 4 left 255 0 0", "Area 4 left", (1, 0, 0)),
        ("2 Precentral_L 2001", "Precentral_L", None),
        ("2 Layer 2 3", "Layer 2 3", None),
        ("2 centroid 10.5 -20 30", "centroid", None),
    ],
)
def test_names_may_end_with_numbers(line, name, colour, tmp_path):
    path = tmp_path / "names.txt"
    path.write_text(f"1 plain 0 0 255\n{line}\n{'9' * 5000} far\n")
    table = read_label_table(path)
    assert table.names == {1: "plain", 2: name}
    assert table.colours.get(2) == colour


def test_a_name_stands_for_all_that_have_it():
    labels = al.Labels(volume(), names={3: "rib", 7: "rib", 9: "spine"})
    assert labels.hide("rib").hidden == {3, 7}


def test_kept_arrays_are_read_only():
    labels = al.Labels(volume())
    for array in (labels.ids(), styles_table(labels)):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_labels_equal_to_the_image_are_alone():
    layer = al.Layer(volume(), TF, labels=al.Labels(volume()))
    assert layer.labels.volume is not layer.volume
    assert layer.stages()["field"].name == "occupancy"
    assert layer.labels.hidden == {0}


@pytest.mark.data
def test_names_of_an_atlas(data_dir):
    labels = read_label_table(data_dir / "labels" / "aal.nii.txt").applied_to(
        al.Labels(al.open(data_dir / "labels" / "aal.nii.gz"))
    )
    assert labels.only("Hippocampus_L").opacity_of(37) == 1
    assert len(labels.names) == 116
    assert not labels.styles
