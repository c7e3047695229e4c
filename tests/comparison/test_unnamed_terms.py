"""A comparison states the flexible terms of both calibrations, with their size; they have no name that could stand for them."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.compare import describe_comparison
from scalar.comparison import compare
from scalar.comparison.unnamed_terms import unnamed_terms
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated
from tests.robot_configs import robot_mapping

TURN = 1e-4  # rad, of joint 1 at either end of the campaign
HOURS = Variable("time", 5000.0, 5000.0)


@pytest.fixture(scope="module")
def arm():
    """Return a calibration of an arm without effects, with standard errors of a few parameters."""
    made = calibrated(Robot.from_mapping(robot_mapping("vs060")), np.random.default_rng(1))
    return replace(made, free=("a_3", "theta_3", "alpha_4", "sensor_x"), covariance=np.eye(4) * 1e-10)


def turning(calibration, variable, size=TURN):
    """Return the calibration with a term by which joint 1 errs in proportion to a variable, by a size [rad] at the ends of its range."""
    term = UnattributedJoint(1, (variable,))
    coefficients = np.zeros(len(term.coefficient_names))
    coefficients[0] = size  # of the first Legendre polynomial, which is the variable itself
    return replace(
        calibration, model=replace(calibration.model, effects=(term.with_coefficients(coefficients),))
    )


def test_the_size_is_that_of_the_turn_at_the_arms_length(arm):
    """A joint 1 that errs by u c, u uniform from -1 to 1, moves the sensor by c / sqrt(3) times its distance from the axis."""
    (term,) = unnamed_terms(turning(arm, HOURS).model)
    rng = np.random.default_rng(5)
    low, high = arm.model.nominal.limits.T
    T = arm.predict(rng.uniform(low, high, (20000, 6)))
    origin = arm.model.robot.geometry[[0, 1], 0]  # a_1 and alpha_1, by which the axis is off the base's z
    distance = np.sqrt(np.mean(T[:, 0, 3] ** 2 + T[:, 1, 3] ** 2))
    assert np.abs(origin).max() < 0.01
    assert term.moved.rms == pytest.approx(TURN / np.sqrt(3) * distance, rel=0.15)
    assert term.moved.largest < TURN * np.linalg.norm(T[:, :3, 3], axis=1).max()


def test_each_campaign_is_said_to_have_its_terms(arm):
    """Lines say how many terms each has, what they change and by how much; a term in time belongs to its campaign."""
    lines = describe_comparison(compare(turning(arm, HOURS), turning(arm, HOURS, 2 * TURN)))
    for letter in "AB":
        assert any(line.startswith(f"{letter} has 1 term without a name") for line in lines)
    sized = [line for line in lines if "an error of the angle of joint 1" in line]
    assert len(sized) == 2 and all("varies smoothly with" in line for line in sized)
    assert all("belongs to that campaign" in line for line in sized)
    assert not any("without a name" in line for line in describe_comparison(compare(arm, arm)))


def test_terms_that_differ_are_not_called_none(arm):
    """Terms in different joints' angles make positions differ: the line says that both have such terms, and that no option frees them."""
    one, other = (turning(arm, Variable(name, 0.0, 2.0), 0.01) for name in ("q2", "q3"))
    said = "\n".join(describe_comparison(compare(one, other)))
    assert "A 1 term without a name; B 1 term without a name" in said
    assert "none" not in said and "same effects" not in said and "--effects-from" in said


def test_a_term_of_one_campaign_may_be_what_changed(arm):
    """Calibrations without it would hide it, so the other campaign takes it over; a term in time says nothing of another campaign."""
    damaged = turning(arm, Variable("q3", 0.0, 2.0), 0.01)
    note = describe_comparison(compare(arm, damaged))[0]
    assert "calibrate the campaign of A by --effects-from the calibration of B" in note
    assert "of B by" not in note and "compare calibrations without it" not in note
    assert not any(
        "--effects-from" in line for line in describe_comparison(compare(arm, turning(arm, HOURS)))
    )


def test_the_json_has_the_terms(arm):
    """The mapping lists the terms of each calibration, the largest first, with their sizes in millimetres."""
    content = compare(arm, turning(arm, HOURS)).to_mapping()["unnamed_terms"]
    assert content["A"] == [] and [set(term) for term in content["B"]] == [
        {"described_as", "rms_mm", "largest_mm"}
    ]
