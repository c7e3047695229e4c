"""Outside the range that was measured, an error without a name keeps the value that it has at the end of the range."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.geometry.robot import Robot
from tests.robot_configs import robot_mapping
from tests.turning import turning

ARM = Robot.from_mapping({"name": "vs060", **robot_mapping("vs060")})
MEASURED = {"q3": (-0.4, 0.9), "q4": (-1.2, 0.3)}  # rad


def columns(names, q):
    """Return the columns of an error of joint 2 over the angles with these names, at joint angles ``(N, 6)`` [rad]."""
    variables = tuple(Variable.observed(name, np.array(MEASURED[name])) for name in names)
    return UnattributedJoint(2, variables).own_columns(ARM, Poses.from_arrays(q, {}, turning(6)))


@pytest.mark.parametrize("names", [("q3",), ("q4",), ("q3", "q4")])
def test_nothing_grows_outside_the_measured_range(names):
    """Poses beyond an end, by up to two turns, have the columns of the pose at that end; poses within have their own."""
    rng = np.random.default_rng(1)
    low, high = np.full(6, -np.pi), np.full(6, np.pi)
    for name, ends in MEASURED.items():
        low[int(name[1]) - 1], high[int(name[1]) - 1] = ends
    q = rng.uniform(-4 * np.pi, 4 * np.pi, (200, 6))
    np.testing.assert_allclose(columns(names, q), columns(names, np.clip(q, low, high)), atol=1e-12)
    within = rng.uniform(low, high, (200, 6))
    assert np.all(np.ptp(columns(names, within), axis=0) > 0.1)
