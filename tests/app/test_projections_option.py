"""Projections on the command line: which function they get when none is given."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fake_renderer import Drawn

import airlight as al
from airlight.app import cli
from airlight.first_picture import resolve
from airlight.transfer import TransferFunction


@pytest.mark.parametrize(
    ("text", "stage"),
    [
        ("xray:show=transmission,low=0.5,high=3", al.integrate.XRay("transmission", 0.5, 3.0)),
        ("weighted_sum:full=2", al.integrate.WeightedSum(2.0)),
        ("attenuated_mip:attenuation=0.1", al.integrate.AttenuatedMip(0.1)),
        ("depth_shaded_mip:darkest=0.1,near=10,far=300", al.integrate.DepthShadedMip(0.1, 10.0, 300.0)),
        ("local_mip:threshold=300,drop=20", al.integrate.LocalMip(300.0, 20.0)),
    ],
)
def test_parameters_are_those_of_the_classes(
    volume_file: str, drawn: Drawn, tmp_path: Path, text: str, stage: al.Stage
) -> None:
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), "--integrate", text]) == 0
    assert drawn[0][0].layers[0].look.integrate == stage


@pytest.mark.parametrize("name", ["attenuated_mip", "depth_shaded_mip", "local_mip", "weighted_sum"])
def test_values_run_from_black_to_white(volume_file: str, drawn: Drawn, tmp_path: Path, name: str) -> None:
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), "--integrate", name]) == 0
    (layer,) = resolve(drawn[0][0], (8, 8)).layers
    assert isinstance(layer.transfer, TransferFunction)
    assert layer.transfer.colours.tolist() == [[0, 0, 0], [1, 1, 1]]


def test_xrays_of_hounsfield_units(tmp_path: Path, drawn: Drawn) -> None:
    ct = np.full((12, 12, 12), -1000, dtype=np.int16)
    ct[3:9, 3:9, 3:9] = 40
    al.save(al.Volume(ct, units="mm", value_unit="HU", modality="CT"), tmp_path / "ct.nrrd")
    assert cli.main(["render", str(tmp_path / "ct.nrrd"), "-o", str(tmp_path / "a.png"), "--integrate", "xray"]) == 0
    (layer,) = resolve(drawn[0][0], (8, 8)).layers
    assert layer.transfer == TransferFunction.from_hounsfield()
    words = ["--integrate", "xray", "--tf", "0:white:0 100:white:0.1"]
    assert cli.main(["render", str(tmp_path / "ct.nrrd"), "-o", str(tmp_path / "a.png"), *words]) == 0
    assert drawn[1][0].layers[0].transfer == TransferFunction([(0, "white", 0), (100, "white", 0.1)])


def test_presets_are_for_opacity(volume_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--integrate", "local_mip", "--preset", "ct-bone"]
    assert cli.main(["render", volume_file, "-o", str(tmp_path / "a.png"), *words]) != 0
    assert "--preset is for opacity" in capsys.readouterr().err
