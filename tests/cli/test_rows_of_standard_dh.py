"""A user of standard DH reads the rows of the own table wherever a parameter is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.cli.correct_words import lines_on_tool
from scalar.data.dataset import Dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import load_calibration
from scalar.geometry.robot import GEOMETRY
from scalar.geometry.standard_dh import as_stated, from_row, stated_mapping
from scalar.units import MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def standard() -> Dataset:
    """Return seventy-five poses before a tracker of an arm that is described by standard DH: row 2 has the length a_3 of the model."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    return replace(dataset, robot=replace(dataset.robot, standard_end=(0.0, 0.0)))


def with_a_3_longer(dataset: Dataset, length: float) -> Dataset:
    """Return the dataset whose table has a length ``length`` [m] too long."""
    geometry = dataset.robot.geometry.copy()
    geometry[GEOMETRY.index("a"), 2] += length
    return replace(dataset, robot=dataset.robot.with_geometry(geometry))


def written(dataset: Dataset, path: Path) -> Path:
    """Write a dataset with its table of joints in standard DH."""
    dataset.write(path)
    description = path / "dataset.yaml"
    dump_yaml({**load_yaml(description), "robot": stated_mapping(dataset.robot)}, description)
    return path


def run(*arguments):
    """Run ``scalar`` in this process."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def test_a_wrong_length_is_named_by_its_row(standard):
    """The doubt about the set-up names row 2, as the table of the same run does; in modified DH it names a_3."""
    wrong = with_a_3_longer(standard, 100 * MM)
    (said,) = calibrate(wrong).summary["setup"]
    assert said["where"] == "a 2" and "a 2 comes out 100 mm" in said["sentence"]
    assert "a_3" not in said["sentence"]
    modified = replace(wrong, robot=replace(wrong.robot, standard_end=None))
    assert calibrate(modified).summary["setup"][0]["where"] == "a_3"


def test_what_is_not_known_of_the_flange_is_named_by_its_row(standard):
    """Corrected joint angles are written with the row of the last joint."""
    gauge = [{"held": "d_6"}, {"held": "theta_6"}]
    (line,) = lines_on_tool(gauge, standard.robot)
    assert "d 6 and theta 6 are not known" in line
    (line,) = lines_on_tool(gauge, replace(standard.robot, standard_end=None))
    assert "d_6 and theta_6 are not known" in line


@pytest.mark.parametrize("name", ["a 2", "a_3"])
def test_a_parameter_is_held_by_its_row_or_by_its_joint(standard, tmp_path: Path, name):
    """Both names hold row 2 of the table, and the summary says which row was held; without --hold it has a standard error."""
    cell = written(standard, tmp_path / "cell")
    held = run("calibrate", cell, "-o", tmp_path / "out", "--hold", name)
    assert held.exit_code == 0 and "fixed as asked (1): a 2 (a_3)" in held.stdout
    parameter = load_calibration(tmp_path / "out/calibration.json").parameters()["a_3"]
    assert parameter["std"] is None
    assert parameter["value"] == pytest.approx(standard.robot.geometry[GEOMETRY.index("a"), 2], abs=1e-12)


def test_a_row_that_there_is_not_is_refused_with_the_rows_that_there_are(standard, tmp_path: Path):
    """The length of the last row is part of the flange, and no parameter."""
    cell = written(standard, tmp_path / "cell")
    refused = run("calibrate", cell, "-o", tmp_path / "out", "--hold", "a 6")
    assert (
        refused.exit_code == 2 and "no parameter 'a 6'; there are a of the base, a 1, a 2" in refused.stderr
    )


def test_names_of_rows_and_of_joints_are_each_other_s_inverse(standard):
    """Every parameter is found again by the name of its row, in either convention."""
    for robot in (standard.robot, replace(standard.robot, standard_end=None)):
        for name in robot.parameter_names:
            assert from_row(as_stated(name, robot), robot) == name


@pytest.mark.slow
def test_a_plan_near_another_arm_is_refused_by_the_row_that_differs(standard, tmp_path: Path):
    """The refusal has the name that dataset.yaml has."""
    written(standard, tmp_path / "cell")
    written(with_a_3_longer(standard, 1 * MM), tmp_path / "other")
    assert run("calibrate", tmp_path / "cell", "-o", tmp_path / "out").exit_code == 0
    refused = run(
        "plan", tmp_path / "other", "--near", tmp_path / "out/calibration.json", "-o", tmp_path / "p"
    )
    assert refused.exit_code == 2 and "nominal a 2 is" in refused.stderr
