"""What is said where regions of the joint space are held out, and of predictions away from the measured poses."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from scalar.diagnosis.accuracy.expected_errors import ExpectedErrors
from scalar.diagnosis.shipping.focused_choice import FocusedChoice
from scalar.evaluate.workspace_errors import Banded
from scalar.geometry.robot import Robot
from scalar.report.shipped_words import _left_out, _without_effects, shipped_sentences
from tests.robot_configs import robot_mapping


def said(
    *, without_effects: bool, q: np.ndarray | None = None, within_ranges: float = 1e-4, equations: int = 3
) -> str:
    """Return the sentences on a fit whose effects leave 0.6 mm in four held-out regions, where the model without them leaves 0.25 mm.

    Args:
        without_effects: Whether the model without effects is shipped.
        q: ``(N, 6)`` [rad], the measured joint angles of a VS060; over the whole of its limits if None.
        within_ranges: Expected error of predictions within the ranges of the joints [m]; at the measured poses it is 0.1 mm.
        equations: Equations that a pose gives.
    """
    robot = Robot.from_mapping(robot_mapping("vs060"))
    measured = robot.limits.T if q is None else q
    errors = [SimpleNamespace(rms=rms, block=np.arange(4)) for rms in (2.5e-4, 6e-4)]
    state: Any = None
    expected = 1e-4, within_ranges, 1e-4
    choice = FocusedChoice(state, (), (), 1e-4, expected, errors_without=expected, std_without=0.0)
    shipped = SimpleNamespace(
        regions=tuple(errors),
        without_effects=without_effects,
        decided_by="regions" if without_effects else "only_one",
        choice=choice,
        disagreement=None,
        unconfirmed=(),
    )
    sensor = SimpleNamespace(equations_per_pose=equations)
    diagnosis: Any = SimpleNamespace(
        shipped=shipped,
        outer=None,
        halves=None,
        findings=(),
        errors_after={"unseen_rms_mm": None, "held_out_rms_mm": 0.1},
        before=SimpleNamespace(residuals=SimpleNamespace(measurement=sensor)),
        cleaned=SimpleNamespace(dataset=SimpleNamespace(robot=robot, q=measured)),
    )
    stated = ExpectedErrors(*(Banded(error, error / 2, 2 * error) for error in expected[:2]))
    with patch("scalar.report.beyond_ranges.expected_errors", return_value=stated):
        return " ".join(shipped_sentences(diagnosis))


def test_effects_that_do_not_extrapolate_are_said_to_be_findings_only():
    """The sentence states both errors, and that whole regions were held out."""
    text = said(without_effects=True)
    assert (
        "regions of the joint space that are held out as a whole are predicted worse (0.600 mm RMS, 0.250 mm without)"
        in text
    )
    assert "findings only" in text


def test_what_held_out_regions_show_is_said():
    """The sentence states the number of regions, and that errors may be larger farther away."""
    text = said(without_effects=False)
    assert (
        "each of 4 regions" in text and "0.600 mm RMS with the effects" in text and "0.250 mm without" in text
    )
    assert "farther away they may be larger" in text


@pytest.mark.parametrize("spin", [0.0, 2.0])
def test_poses_that_never_tilt_the_tool_are_said_to_show_no_others(spin):
    """Where the tool is not turned, or about its axis alone, the errors at measured and at other poses are stated, and what to measure."""
    turn = np.linspace(-0.5, 0.5, 11)
    q = np.zeros((11, 6))
    q[:, 1], q[:, 2], q[:, 5] = turn, -turn, spin * turn
    text = said(without_effects=False, q=q, within_ranges=8e-3)
    assert "only at poses like those that were measured: there, predictions err by 0.10 mm" in text
    assert "within the same ranges of the joints they are expected to err by 8.0 mm" in text
    assert (
        "kept its direction to within 1 degree," in text
        and "with the tool tilted in other directions" in text
    )


def test_where_the_geometry_alone_is_right_is_said_as_well():
    """What is shipped without effects need not be right everywhere either: the sentence does not depend on whether effects were found."""
    text = said(without_effects=True, within_ranges=8e-3)
    assert "within the same ranges of the joints they are expected to err by 8.0 mm" in text


def test_few_combinations_of_joints_are_said_without_blaming_the_orientation():
    """The orientation varies by a radian, so that it is not the reason."""
    q = np.random.default_rng(2).uniform(-1, 1, (20, 6))
    text = said(without_effects=False, q=q, within_ranges=8e-3)
    assert "measure other combinations" in text and "direction" not in text


def test_a_residual_along_one_direction_is_not_compared_with_an_error_of_the_position():
    """A probe's residual says little about the position, and an error that is little larger than at the measured poses is not mentioned."""
    assert "only at poses like those" not in said(without_effects=False, within_ranges=8e-3, equations=1)
    assert "only at poses like those" not in said(without_effects=False, within_ranges=2e-4)


def test_joints_with_a_narrow_range_are_named():
    """A joint that hardly turned is named with its range and that of its limits, whatever was found; where all turn widely nothing is said."""
    limits = Robot.from_mapping(robot_mapping("vs060")).limits
    q = limits.T.copy()
    q[:, 3] = [-0.3, 0.3]
    text = said(without_effects=False, q=q)
    whole = np.degrees(np.ptp(limits[3]))
    assert (
        f"joint limits: joint 4 over 34 of {whole:.0f} degrees. What the model lacks outside this range"
        in text
    )
    assert "small part" not in said(without_effects=True)


@pytest.mark.parametrize(("with_all", "says"), [(0.5e-4, True), (2e-4, False)])
def test_a_correction_left_out_although_it_promises_more_is_said_to_be_doubtful(with_all, says):
    """Without the reason, a smaller expected error with the correction would speak against leaving it out."""
    expected = (1e-4, 1e-4, 1e-4)
    left: Any = SimpleNamespace(title="harmonic of joint 5")
    state: Any = None
    choice = FocusedChoice(state, (left,), (), with_all, expected, errors_without=expected, std_without=0.0)
    shipped = SimpleNamespace(without_effects=True, decided_by="expected_error", choice=choice)
    for without in (True, False):
        shipped.without_effects = without
        sentences = [*_without_effects(as_diagnosis(shipped)), *_left_out(as_diagnosis(shipped))]
        assert len(sentences) == 1
        assert ("may do harm" in sentences[0]) == says


def as_diagnosis(shipped: SimpleNamespace) -> Any:
    """Return a stand-in for a diagnosis, of which only what is shipped matters."""
    return SimpleNamespace(shipped=shipped)
