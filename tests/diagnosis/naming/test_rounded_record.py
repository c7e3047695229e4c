"""Joint angles that were rounded and recur look like an effect, and lower the confidence in names."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.rounded_record import limited_by_rounding, recur
from scalar.units import DEG, MM
from tests.diagnosis.stand_ins import finding_of
from tests.random_scene import make_scene

STEP = 0.01 * DEG
LEAST = 0.6


def one_joint_at_a_time(step: float) -> np.ndarray:
    """Return 180 poses in which one of six joints moves at a time from one of three homes, angles rounded to multiples of a step [rad]."""
    rng = np.random.default_rng(5)
    q = np.repeat(rng.uniform(-1.0, 1.0, (3, 6)), 60, axis=0)
    for i in range(180):
        q[i, (i // 10) % 6] = rng.uniform(-1.0, 1.0)
    return np.round(q / step) * step if step else q


def state(q: np.ndarray, residual: float) -> Any:
    """Return what the rule reads of a fitted state: an arm of a metre and a half, joint angles, and the residual [m]."""
    robot = make_scene("vs060", "tracker", poses_per_plane=5).dataset.robot
    residuals = SimpleNamespace(rms=lambda model: residual)
    return SimpleNamespace(dataset=SimpleNamespace(robot=robot, q=q), residuals=residuals, model=None)


def limited(q: np.ndarray, residual: float) -> tuple[Finding, ...]:
    """Return a name and a flexible term after the rule."""
    name, term = (finding_of(SimpleNamespace(flexible=flexible), 0.98) for flexible in (False, True))
    return limited_by_rounding([name, term], state(q, residual), LEAST)


def test_a_name_that_rounding_may_explain_is_doubtful():
    """Rounded angles that recur leave a twentieth of a millimetre: the name is doubtful, and a term without a name stays as it is."""
    name, term = limited(one_joint_at_a_time(STEP), 0.05 * MM)
    assert name.confidence == ONE_OF_TWO and name.doubtful
    assert term.confidence == 0.98 and not term.doubtful


@pytest.mark.parametrize(
    ("step", "residual"), [(0.0, 0.05 * MM), (STEP, 1.0 * MM)], ids=["not rounded", "a larger residual"]
)
def test_a_name_that_rounding_does_not_explain_is_kept(step, residual):
    """Angles with all decimals, or a residual far beyond what rounding leaves, lower no confidence."""
    assert limited(one_joint_at_a_time(step), residual)[0].confidence == 0.98


def test_angles_that_differ_at_each_pose_do_not_recur():
    """Random poses have a rounding error of their own each, which is a random error of the poses."""
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (180, 6))
    assert not recur(np.round(q / STEP) * STEP)
    assert recur(one_joint_at_a_time(STEP))
