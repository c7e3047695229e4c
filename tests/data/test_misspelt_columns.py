"""A column of poses.csv that may be misspelt is said, and one of the user's own is not."""

from dataclasses import replace

import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.covariates import misspelt_columns
from scalar.data.located_table import Layout, header_faults
from scalar.estimation.calibrate import calibrate
from tests.random_scene import make_scene

OWN = ["pose", "plane", "q1", "q2"]


@pytest.mark.parametrize(
    ("columns", "meant"),
    [
        (["aproach1", "aproach2"], "'approach1', rename it, and 'aproach2' likewise"),
        (["Session"], "'session'"),
        (["sesion"], "'session'"),
        (["payload_kg"], "'payload'"),
        (["Temperature"], "'temperature'"),
        (["time_s"], "'time'"),
        (["tau_1"], "'tau1'"),
    ],
)
def test_names_that_are_almost_known_are_said(columns, meant):
    told = misspelt_columns([*OWN, *columns], 2)
    assert len(told) == 1 and meant in told[0] and columns[0] in told[0]


@pytest.mark.parametrize(
    "column",
    [
        "ambient",
        "border",
        "lane",
        "approach",
        "approach7",
        "temperature1",
        "tau",
        "order2",
        "speed",
        "humidity",
        "motor_temperature1",
        "current1",
        "posture",
        "qc1",
        "approach1",
    ],
)
def test_columns_of_ones_own_and_known_ones_are_not(column):
    assert misspelt_columns([*OWN, column], 2) == []


def test_a_column_that_may_also_be_known_by_its_right_name_is_not():
    assert misspelt_columns([*OWN, "time", "time_s"], 2) == []


def test_commands_say_it(tmp_path):
    scene = make_scene("vs060", "tracker", seed=2, poses_per_plane=20)
    scene.write(tmp_path / "cell")
    path = tmp_path / "cell" / "poses.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([f"{lines[0]},Temperatur", *(f"{line},21.5" for line in lines[1:])]) + "\n")
    result = CliRunner().invoke(cli, ["validate", str(tmp_path / "cell")])
    assert result.exit_code == 0 and "'Temperatur'" in result.output and "'temperature'" in result.output
    dataset = scene.dataset
    poses = dataset.poses.assign(Temperatur=21.5)
    told = [entry["sentence"] for entry in calibrate(replace(dataset, poses=poses)).summary["setup"]]
    assert any("'temperature'" in sentence for sentence in told)


@pytest.mark.parametrize(
    ("written", "name", "unit"),
    [("q1_deg", "q1", "radians"), ("x_mm", "x", "metres"), ("x [mm]", "x", "metres")],
)
def test_a_column_in_another_unit_is_converted_and_not_only_renamed(written, name, unit):
    """Nobody is told to give degrees the name of a column of radians, in a table that keeps further columns or in another one; once is enough."""
    for kept in (True, False):
        faults = header_faults("table.csv", ["pose", written], Layout(("pose", name), extras=kept))
        assert len(faults) == 1
        assert f"{written!r}? convert its numbers to {unit} and rename it" in faults[0].message


def test_a_column_of_another_name_is_renamed():
    faults = header_faults("table.csv", ["pose", "J1"], Layout(("pose", "q1"), extras=True))
    assert len(faults) == 1 and "is it 'J1'? rename it" in faults[0].message
