"""The terms of a lag: named on a command line, saved, merged, and zero at rest."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.command_line import named_effects, parse_effects
from scalar.effects.pose_lag import SPEED, STEP, TERMS, PoseLag
from scalar.errors import InvalidInput
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def dataset():
    """Return a tracked arm of six joints."""
    return make_scene(kind="tracker", seed=3, poses_per_plane=5).dataset


@pytest.mark.parametrize(
    ("text", "terms"), [("2", (STEP,)), ("2:speed", (SPEED,)), ("2:step:speed:passing", TERMS)]
)
def test_a_command_line_names_the_terms_and_reads_them_again(text, terms, dataset):
    """The step alone needs no word; what is written for a lag gives the same lag."""
    (effect,) = parse_effects(f"pose_lag:{text}", dataset)
    assert (effect.joint, effect.terms) == (2, terms)
    assert named_effects([effect]) == f"pose_lag:{text}"


def test_a_word_that_is_no_term_is_refused(dataset):
    """The message says what a lag may be in proportion to."""
    with pytest.raises(
        InvalidInput,
        match="'angle' is nothing that a lag is in proportion to; there are step, speed and passing",
    ):
        parse_effects("pose_lag:2:angle", dataset)


def test_terms_are_saved_and_files_without_them_have_the_step():
    """A lag of both terms comes back; one of an earlier version is in proportion to the step."""
    lag = PoseLag(3, True, TERMS)
    assert PoseLag.from_mapping(lag.to_mapping()).terms == TERMS
    assert PoseLag.from_mapping({"joint": 3}).terms == (STEP,)
    assert PoseLag(3).to_mapping() == {"joint": 3}


def test_two_terms_of_one_joint_become_one_effect():
    """The coefficients of the first are kept; lags of different joints stay apart."""
    step, speed = PoseLag(3, coefficients=np.array([0.5])), PoseLag(3, terms=(SPEED,))
    both = step.merged_with(speed)
    assert both is not None and both.terms == (STEP, SPEED)
    np.testing.assert_array_equal(both.coefficients, [0.5, 0.0])
    assert step.merged_with(PoseLag(4)) is None


@pytest.mark.parametrize(
    ("share", "at_full_speed", "when"), [(-3e-4, 1.5e-3, "before"), (3e-4, -1.5e-3, "after")]
)
def test_the_larger_term_says_whether_the_angle_was_logged_before_or_after(share, at_full_speed, when):
    """A small share of the step of the other sign does not turn the sentence round."""
    lag = PoseLag(5, terms=(STEP, SPEED), coefficients=np.array([share, at_full_speed]))
    assert f"was logged {when} the joint stood" in lag.clause


def test_lags_of_several_joints_are_said_once():
    """One clause names all joints; it says before or after, or both where the joints differ."""
    lags = [
        PoseLag(joint, coefficients=np.array([share])) for joint, share in ((5, 1e-3), (1, 2e-3), (2, 1e-3))
    ]
    assert PoseLag.clause_of(lags).startswith("joints 1, 2 and 5 were logged before they stood")
    lags[0] = PoseLag(5, coefficients=np.array([-1e-3]))
    assert "were logged before or after they stood" in PoseLag.clause_of(lags)


def test_an_arm_at_rest_has_no_lag(dataset):
    """Where no moves are known, all columns are zero."""
    rest = Poses(np.zeros((2, 6)), np.zeros(2), {})
    assert not PoseLag(3, terms=TERMS).joint_basis(dataset.robot, rest).any()
