"""Single lines of the commands: numbers and names are written as a reader expects them."""

import numpy as np
import pandas as pd
import pytest

from scalar.cli.correct_words import warnings_on_written
from scalar.cli.diagnosis_words import in_ascii, set_aside_in_words
from scalar.data.dataset_writer import write_dataset
from scalar.estimation.correction import Correction, Sensitivity
from scalar.geometry.robot import Robot
from scalar.units import DEG, MM
from tests import small_datasets
from tests.cli.running import run
from tests.robot_configs import robot_mapping


@pytest.mark.parametrize(
    ("poses", "mislabelled", "points", "said"),
    [
        ([18], [], 0, "pose 18"),
        ([3, 18], [], 1, "poses 3, 18 and 1 point"),
        ([], [], 7, "7 points"),
        ([1, 2, 3, 4, 5, 6, 7], [{"pose": 2}], 0, "poses 1, 2, 3, 4, 5 and 2 more (1 on another plane than stated)"),
    ],
)  # fmt: skip
def test_what_was_set_aside_is_named(poses, mislabelled, points, said):
    """The first poses stand by their numbers, and planes are mentioned only where a label was wrong."""
    assert set_aside_in_words({"poses": poses, "mislabelled": mislabelled, "points": points}) == said


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("errs by 1.85 × 10⁻¹² mm", "errs by 1.85e-12 mm"),
        ("p < 10⁻¹²", "p < 1e-12"),
        ("−4.0 ± 2.5 mm/m², 3° × 10 poses", "-4.0 +- 2.5 mm/m2, 3deg x 10 poses"),
    ],
)
def test_terminals_that_show_only_ascii_get_powers_of_ten(text, plain):
    """An exponent is legible, whichever digits it has."""
    assert in_ascii(text) == plain


@pytest.mark.parametrize(
    ("move", "said"), [(7.04, "up to 7 deg"), (99.7, "up to 100 deg"), (173.2, "up to 173 deg"), (200.0, "more than 180 deg")]
)  # fmt: skip
def test_large_motions_near_a_singularity_have_no_exponent(move, said):
    """A motion of a joint by more than a hundred degrees is written in digits."""
    robot = Robot.from_mapping(robot_mapping("vs060"))
    n = robot.n_joints
    zero, no = np.zeros(1), np.zeros(1, dtype=bool)
    found = Correction(np.zeros((1, n)), np.eye(4)[None], zero, zero, ~no, np.zeros((1, n), dtype=bool), no)
    travel = np.zeros((1, n))
    travel[0, 3] = move * DEG / MM
    (line,) = warnings_on_written(robot, np.array([1]), found, Sensitivity(np.array([1e-3]), travel))
    assert line.endswith(f"joint 4 moves by {said})")


@pytest.mark.parametrize("kind", ["tracker", "line-laser"])
@pytest.mark.parametrize("step", [0.0, 1e-6])
def test_a_copied_pose_is_named(kind, step, tmp_path):
    """`validate` names a pose that repeats another one to the last digit; the same joint angles measured anew are no copy."""
    tables = small_datasets.tables(kind)
    for name, table in tables.items():
        if table is None:
            continue
        again = table[table["pose"] == 12].assign(pose=99)
        if name != "poses":
            again["z"] += step
        tables[name] = pd.concat([table, again], ignore_index=True)
    write_dataset(tmp_path / "d", mapping=small_datasets.description(kind), **tables)
    result = run("validate", tmp_path / "d")
    assert result.exit_code == 0, result.output
    assert ("poses 12 and 99 have the same joint angles and measurements" in result.output) == (step == 0)


@pytest.mark.parametrize("size", [1.0, DEG])
def test_radians_that_were_taken_for_degrees_are_noted(size, tmp_path):
    """`validate` asks about the unit if no joint turns by more than radians would make of it that were read as degrees."""
    tables = small_datasets.tables("tracker")
    poses = pd.concat([tables["poses"].assign(pose=lambda t, k=k: t["pose"] + 100 * k) for k in range(3)])
    points = pd.concat(
        [tables["points"].assign(pose=lambda t, k=k: t["pose"] + 100 * k, x=1.0 + k) for k in range(3)]
    )
    poses[[f"q{i}" for i in range(1, 7)]] *= size
    write_dataset(tmp_path / "d", mapping=small_datasets.description("tracker"), poses=poses, points=points)
    result = run("validate", tmp_path / "d")
    assert result.exit_code == 0, result.output
    assert ("were radians taken for degrees?" in result.output) == (size == DEG)


def test_coefficients_that_no_pose_shows_have_one_line(sound, tmp_path):
    """The weight of an upright arm puts no torque on joint 1, so nothing shows its compliance: it is not listed among the estimates."""
    result = run("calibrate", sound / "dataset", "-o", tmp_path / "out", "--effects", "joint_compliance:1:2")
    assert result.exit_code == 0, result.output
    (line,) = [
        line for line in result.output.splitlines() if line.startswith("  zero, because no pose shows them: ")
    ]
    assert "joint1_frame1_x_rad" in line and line.endswith("more") and "joint2" not in line
    listed = [line for line in result.output.splitlines() if line.startswith("  effect joint_compliance.")]
    assert listed and all("joint2" in line for line in listed)
