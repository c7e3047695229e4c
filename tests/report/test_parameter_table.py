"""The table of parameters has the numbers of the robot's own table, in its own rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.calibration_words import describe_calibration
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.estimation.result import load_calibration
from scalar.geometry.robot import Robot
from scalar.geometry.roll_pitch_yaw import rotation_from_rpy
from scalar.geometry.standard_dh import in_rows, read_as_standard
from scalar.report.parameter_table import (
    _fixed,
    _signed,
    convention_in_words,
    gauge_rows,
    parameter_tables,
)
from scalar.robots import read_arm
from tests.calibrated_arms import T_SENSOR, calibrated

ROWS = [
    {"a": 0.0, "alpha": 1.5, "d": 0.1, "theta": 0.0},
    {"a": -0.4, "alpha": 0.2, "d": 0.02, "theta": -1.0},
    {"a": 0.05, "alpha": -1.4, "d": 0.3, "theta": 0.5},
]


def test_zero_has_no_sign() -> None:
    """A value that rounds to zero is 0.0000 from either side, and a change of zero is +0.0000."""
    for value in (-1e-12, -0.0, 0.0, 1e-12):
        assert _fixed(value, 4) == "0.0000" and _signed(value, 4) == "+0.0000"


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_the_rows_are_those_of_the_robots_own_table(convention: str) -> None:
    """Names and data-sheet values are the numbers as they were declared, in mm and degrees, in either convention; only the end of the last
    link of a standard-DH table is a part of the flange."""
    robot = Robot.from_mapping({"name": "arm", "convention": convention, "joints": ROWS})
    tables = parameter_tables(calibrated(robot, np.random.default_rng(0)), None)
    stated = {
        row["name"]: float(row["nominal"].replace("−", "-"))
        for table in tables
        for row in table["rows"]
        if " " in row["name"]
    }
    expected = {
        f"{kind} {i + 1}": value * 1e3 if kind in "ad" else np.degrees(value)
        for i, declared in enumerate(ROWS)
        for kind, value in declared.items()
        if not (convention == "standard-dh" and i == 2 and kind in ("a", "alpha"))
    }
    assert stated.keys() == expected.keys()
    for name, value in expected.items():
        assert stated[name] == pytest.approx(value, abs=6e-4)


def test_found_less_data_sheet_is_the_change_and_bold_is_beyond_chance() -> None:
    """Change, found and data sheet fit together; a change is marked if it exceeds 1.96 standard errors, and what is fixed is never marked."""
    robot = Robot.from_mapping({"name": "arm", "joints": ROWS})
    calibration = calibrated(robot, np.random.default_rng(1))
    free = tuple(f"{kind}_{i}" for kind in ("a", "alpha", "d", "theta") for i in (2, 3))
    calibration = replace(calibration, free=free, covariance=np.diag(np.full(len(free), 2.5e-7)))
    tables = parameter_tables(calibration, T_SENSOR)
    assert [table["unit"] for table in tables] == ["mm", "°", "mm", "°"][: len(tables)]
    marked = 0
    for row in [row for table in tables for row in table["rows"]]:
        if row["error"] == "fixed":
            assert not row["beyond_chance"] and row["change"] == "–"
            continue
        number = {k: float(row[k].replace("−", "-")) for k in ("nominal", "found", "change", "error")}
        assert number["found"] - number["nominal"] == pytest.approx(number["change"], abs=2e-3)
        assert row["beyond_chance"] == (abs(number["change"]) > 1.96 * number["error"])
        marked += row["beyond_chance"]
    assert 0 < marked < len(free)


def test_what_was_fixed_is_named_by_the_same_rows() -> None:
    """Modified DH's a_3, alpha_3 and beta_3 are those of row 2 of a standard-DH table; its d_3 is that of row 3; nothing else is renamed."""
    entry = {
        "held": "a_3",
        "reason": "moves with alpha_3 and d_3 of floor_2",
        "moves_with": ["beta_3", "sensor_x"],
        "cause": "gauge",
    }
    for convention, rows in (
        ("standard-dh", ("a 2", "moves with alpha 2 and d 3 of floor_2", ["beta 2", "sensor_x"])),
        ("modified-dh", ("a 3", "moves with alpha 3 and d 3 of floor_2", ["beta 3", "sensor_x"])),
    ):
        robot = Robot.from_mapping({"name": "arm", "convention": convention, "joints": ROWS})
        made = replace(
            calibrated(robot, np.random.default_rng(0)), gauge=(entry,), summary={"poses": 9, "points": 9}
        )
        first, *others = gauge_rows(made)
        assert first == dict(zip(("held", "reason", "moves_with"), rows, strict=True))
        of_flange = [f"a {len(ROWS)}, alpha {len(ROWS)}"] if convention == "standard-dh" else []
        assert [row["held"] for row in others] == of_flange
        lines = describe_calibration(made)
        assert all(f"{held}: part of the flange" in lines for held in of_flange)
        assert ("standard-DH table of dataset.yaml" in lines) == (convention == "standard-dh")
        assert ("a 2: moves with" in lines) == (convention == "standard-dh")


def test_what_precedes_the_first_row_is_named_as_part_of_the_base() -> None:
    """A standard-DH table has no row 0."""
    robot = Robot.from_mapping({"name": "arm", "convention": "standard-dh", "joints": ROWS})
    assert in_rows("a_1 and d_1, alpha_2", robot) == "a of the base and d 1, alpha 1"


def test_a_saved_calibration_knows_its_table(tmp_path) -> None:
    """After saving and loading, an arm still has its standard-DH table, to the end of its last link."""
    robot = Robot.from_mapping({"name": "arm", "convention": "standard-dh", "joints": ROWS})
    calibrated(robot, np.random.default_rng(0)).save(tmp_path / "calibration.json")
    loaded = load_calibration(tmp_path / "calibration.json")
    assert loaded.model.nominal.standard_end == loaded.model.robot.standard_end == (0.05, -1.4)


def test_a_tilt_that_an_effect_holds_stands_among_the_angles() -> None:
    """Beta has no row unless it is estimated; as the effect axis_nonparallel it has one, with its value, its change and its standard error."""
    robot = Robot.from_mapping({"name": "arm", "joints": ROWS})
    made = calibrated(robot, np.random.default_rng(0), size=0.0)
    tilt = AxisNonparallel(2, coefficients=np.array([2e-3]))
    made = replace(made, model=replace(made.model, effects=(tilt,)))
    made = replace(made, free=tuple(made.model.effect_names[0]), covariance=np.array([[1e-8]]))
    rows = {row["name"]: row for table in parameter_tables(made, None) for row in table["rows"]}
    assert [name for name in rows if name.startswith("beta")] == ["beta 2"]
    beta = rows["beta 2"]
    assert float(beta["found"]) == pytest.approx(np.degrees(2e-3), abs=1e-3)
    assert float(beta["error"]) == pytest.approx(np.degrees(1e-4), abs=1e-3)
    assert beta["beyond_chance"]


def test_the_sensor_is_turned_by_the_roll_pitch_and_yaw_that_are_shown() -> None:
    """Beside the rotation vector stand the angles of the same rotation, where the data observe it, and on the terminal."""
    robot = Robot.from_mapping({"name": "arm", "joints": ROWS})
    made = replace(
        calibrated(robot, np.random.default_rng(0)),
        free=("sensor_rx",),
        covariance=np.array([[1e-8]]),
        summary={"poses": 9, "points": 9},
    )
    rows = {row["name"]: row for table in parameter_tables(made, T_SENSOR) for row in table["rows"]}
    shown = np.radians([float(rows[name]["found"].replace("−", "-")) for name in ("roll", "pitch", "yaw")])
    np.testing.assert_allclose(rotation_from_rpy(shown), T_SENSOR[:3, :3], atol=1e-4)
    line = next(line for line in describe_calibration(made).splitlines() if "sensor on flange" in line)
    said = np.radians([float(x) for x in line.partition("roll pitch yaw [")[2].partition("]")[0].split()])
    np.testing.assert_allclose(said, shown, atol=1e-4)


def test_the_terminal_says_how_far_the_sensor_is_from_its_stated_place():
    """A stated place that is 30 mm off shows in the line on the sensor; where none is stated, the line says nothing of it."""
    robot = Robot.from_mapping({"name": "arm", "joints": ROWS})
    made = replace(calibrated(robot, np.random.default_rng(0)), summary={"poses": 9, "points": 9})
    stated = made.model.T_flange_sensor.copy()
    stated[:3, 3] += [0.01, -0.02, 0.02]
    assert "; 30.0 mm from where nominal_pose has it" in describe_calibration(made, stated)
    assert "nominal_pose" not in describe_calibration(made)


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_the_makers_name_of_an_axis_stands_beside_the_joint(convention: str) -> None:
    """A reader who knows the arm by its manual finds axis L in row 2; an arm that the library does not know has numbers alone."""
    robot = Robot.from_mapping(read_arm("yaskawa_gp7").mapping)
    if convention == "standard-dh":
        robot = read_as_standard(robot)
        robot = replace(robot, name="my own arm")
    made = calibrated(robot, np.random.default_rng(0))
    names = [row["name"] for table in parameter_tables(made, None) for row in table["rows"]]
    if convention == "modified-dh":
        assert {"a 1 (S)", "d 2 (L)", "alpha 3 (U)", "theta 4 (R)", "d 5 (B)", "theta 6 (T)"} <= set(names)
        assert "what the maker calls the axis" in convention_in_words(robot)
    else:
        assert not any("(" in name for name in names)
        assert "maker" not in convention_in_words(robot)
