"""Functions as files, text and plain data: exact round trips, and errors that name the line."""

from __future__ import annotations

from pathlib import Path

import pytest
from functions import any_functions
from hypothesis import given

import airlight as al
from airlight.errors import AirlightError, FileError, ValueRangeError
from airlight.scene_file import load_transfer
from airlight.transfer import TransferFunction

TF = TransferFunction([(-0.1, "red", 0.1), (3.5, (0.1, 1 / 3, 5e-324), 1e300)], associated=True)


@given(any_functions())
def test_round_trips_are_exact(tmp_path_factory, tf):
    path = tmp_path_factory.getbasetemp() / "function.toml"
    assert TransferFunction.from_dict(tf.to_dict()) == tf
    assert eval(tf.as_code(), {"al": al}) == tf
    tf.save(path)
    assert TransferFunction.load(path) == tf
    assert hash(TransferFunction.load(path)) == hash(tf)


def test_files_are_those_of_scenes_and_of_the_command_line(tmp_path):
    TF.save(tmp_path / "tf.toml")
    assert load_transfer(tmp_path / "tf.toml") == TF
    assert (tmp_path / "tf.toml").read_text().splitlines()[1:3] == ["points = [", "  [-0.1, [1.0, 0.0, 0.0], 0.1],"]


def test_words_and_whole_numbers_are_read(tmp_path):
    (tmp_path / "tf.toml").write_text('points = [[0, "black", 0], [10, "#ff8800", 1]]\n')
    assert TransferFunction.load(str(tmp_path / "tf.toml")) == TransferFunction([(0, "black", 0), (10, "#ff8800", 1)])


def test_no_partial_file_is_left(tmp_path, monkeypatch):
    path = tmp_path / "tf.toml"
    TransferFunction([(0, "red", 1)]).save(path)
    before = path.read_bytes()

    def full_disk(self, text, **_):
        with open(self, "w") as file:
            file.write(text[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full_disk)
    with pytest.raises(FileError, match=r"tf.toml cannot be written \(No space left on device\)"):
        TF.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_folder_must_be_there(tmp_path):
    with pytest.raises(FileError, match=r"no.tf.toml cannot be written, its folder is not there: make "):
        TF.save(tmp_path / "no" / "tf.toml")


HEAD = "# a [comment]\nassociated = false\npoints = [\n  [0, 'black', 0],  # [\n"


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        (
            HEAD + "  [5, [1, 1, 1], -1],\n]",
            ValueRangeError,
            r"tf.toml:5: transfer.points\[1\].extinction is -1, must be at least 0",
        ),
        (HEAD + "\n  [-5, '#fff', 1],\n]", ValueRangeError, r"tf.toml:6: transfer.points\[1\] has value -5, below the 0"),
        (HEAD + "  [nan, '#fff', 1]]", ValueRangeError, r"tf.toml:5: transfer.points\[1\].value is nan, must be a finite"),
        (
            HEAD + "  ['9', '#fff', 1]]",
            ValueRangeError,
            r"tf.toml:5: transfer.points\[1\].value is '9', must be a finite",
        ),
        (HEAD + "  [1, 'blak', 1]]", ValueRangeError, r"tf.toml:5: transfer.points\[1\].colour is 'blak'"),
        (HEAD + "  [1, ['a', 1, 2], 1]]", ValueRangeError, r"tf.toml:5: transfer.points\[1\].colour is \['a', 1, 2\]"),
        (HEAD + "  [1, 'red']]", ValueRangeError, r"tf.toml:5: transfer.points\[1\] is \[1, 'red'\]"),
        (HEAD + "  [1, 'red', true]]", ValueRangeError, r"tf.toml:5: transfer.points\[1\].extinction is True, must be"),
        (
            HEAD + f"  [{'9' * 400}, 'red', 1]]",
            ValueRangeError,
            r"tf.toml:5: transfer.points\[1\].value is 9+, must be a",
        ),
        (HEAD + "  3]", ValueRangeError, r"tf.toml:3: transfer.points\[1\] is 3: give"),
        ("points = []", ValueRangeError, r"tf.toml:1: transfer.points is empty"),
        ("", ValueRangeError, r"tf.toml: transfer.points is empty"),
        ("points = 3", ValueRangeError, r"tf.toml:1: transfer.points is 3: write"),
        ("points = [[0, 'red', 1]]\nassociated = 1", ValueRangeError, r"tf.toml:2: transfer.associated is 1, must be true or"),
        ("points = [[0, 'red', 1]]\ncode = 'os:remove'", ValueRangeError, r"unknown entries \['code'\]: use points and"),
        ("points = [[0, 'red', 1]\n\n]]", FileError, r"tf.toml is no sound TOML \(.*line 3"),
        ("points = " + "[" * 5000, FileError, "tf.toml is no sound TOML"),
    ],
)
def test_bad_files_name_line_and_entry(tmp_path, text, error, message):
    (tmp_path / "tf.toml").write_text(text)
    with pytest.raises(error, match=message):
        TransferFunction.load(tmp_path / "tf.toml")


def test_missing_and_foreign_files(tmp_path):
    with pytest.raises(FileError, match=r"no.toml cannot be read \(No such file"):
        TransferFunction.load(tmp_path / "no.toml")
    (tmp_path / "image.toml").write_bytes(b"\x89PNG\xff\x00")
    with pytest.raises(AirlightError, match="no sound TOML"):
        TransferFunction.load(tmp_path / "image.toml")
