"""Play whose side the weight decides is named if the joint rests on the lower side, and not if it rests on the upper one."""

import numpy as np
import pytest

from scalar import diagnose
from tests.effects.injected import Flaws, gravity_torques, make_cell, on_joint

HALF_WIDTH = 6e-4  # rad


def found(half_width: float, seed: int):
    """Return the findings on joint 2, whose angle errs by ``half_width`` with the sign of its gravity torque."""
    truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
    n = truth.geometry.shape[1]
    masses, centres = np.linspace(8.0, 1.0, n), np.zeros((n, 3))
    error = on_joint(2, lambda at: half_width * np.sign(gravity_torques(truth, at.q, masses, centres)[:, 1]))
    findings = diagnose(make_cell(Flaws(joints=error), seed=seed).dataset).findings
    return [f for f in findings if f.effect.erring_joint == 2]


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_play_on_the_side_of_the_load_is_named(seed):
    """A joint that rests on the lower side of its play is named with a high confidence."""
    (finding,) = found(HALF_WIDTH, seed)
    assert finding.effect.name == "joint_backlash" and finding.has_name
    assert finding.confidence > 0.8


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_play_against_the_load_is_no_name(seed):
    """A step to the other side is corrected for, but its cause is not play: the weight would have to lift the arm."""
    (finding,) = found(-HALF_WIDTH, seed)
    assert finding.effect.name == "joint_backlash" and not finding.has_name
    assert finding.confidence < 1e-3
