"""Friction that winds a joint up is named where its moves are short and long in turns; play, lag and scale are not called so.

The friction is the simulator's: springs with sliders. The data are those of ``tests.tracked_moves``.
"""

import numpy as np
import pytest

from scalar import diagnose
from scalar.simulation.injected.moves import stretched
from tests.tracked_moves import tracked

WIDTH, TRAVEL = 6e-4, 0.3  # rad
SEEDS = [700, pytest.param(701, marks=pytest.mark.slow)]


def findings(error, joint, seed):
    """Return name and target of what a diagnosis finds."""
    return [(f.effect.name, f.effect.target) for f in diagnose(tracked(error, joint, seed)).findings]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_joint_that_friction_winds_up_is_named(seed):
    """The hysteresis of the joint that friction winds up is named, and nothing else is."""
    found = findings(lambda q: WIDTH * stretched(q, TRAVEL), 3, seed)
    assert found == [("joint_hysteresis", {"joint": 3})]


@pytest.mark.parametrize("seed", SEEDS)
def test_play_is_not_called_hysteresis(seed):
    """A joint that rests on the side from which it came, after a short move as after a long one, has play and is not named for hysteresis."""
    found = findings(lambda q: WIDTH / 2 * np.sign(np.diff(q, prepend=q[0] - 1.0)), 3, seed)
    assert found == [("joint_backlash", {"joint": 3})]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_lag_is_not_called_hysteresis(seed):
    """An angle that errs by a share of the last step is named a lag, and not hysteresis."""
    assert findings(lambda q: 2e-3 * np.diff(q, prepend=q[0]), 2, seed) == [("pose_lag", {"joint": 2})]


@pytest.mark.parametrize("seed", SEEDS)
def test_moves_alone_are_no_finding(seed):
    """With such moves and no error of the arm, nothing is named."""
    assert "joint_hysteresis" not in {name for name, _ in findings(np.zeros_like, 1, seed)}
