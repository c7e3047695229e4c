"""A motion of the sensor without a name is not carried on beyond the acquisition: later predictions are those for the sensor's mean pose."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.effects.flexible.sway import UnattributedSway
from scalar.effects.flexible.variable import Variable
from scalar.effects.flexible.wander import UnattributedWander

LAST = 100.0  # [s]
TIME = Variable("time", LAST / 2, LAST / 2)


def at(*times: float) -> Poses:
    """Return poses at some times [s]."""
    return Poses(np.zeros((len(times), 6)), np.arange(float(len(times))), {"time": np.array(times)})


TERMS = [
    UnattributedSway(TIME, 2.5),
    UnattributedSway(TIME, 0.31, turns=False),
    UnattributedWander(TIME, "x"),
]


@pytest.mark.parametrize("term", TERMS, ids=["sway", "slow sway", "wander"])
def test_later_poses_are_those_of_one_sensor(term):
    """Before the acquisition and from its end on the sensor stays where it is; a time that is not given stands for the end."""
    screws = term.sensor_screws(None, at(-1.0, LAST, LAST + 1.0, np.nan, 20.0))
    np.testing.assert_array_equal(screws[1:4], screws[:1].repeat(3, axis=0))
    assert np.abs(screws[4] - screws[0]).max() > 0.1


@pytest.mark.parametrize("term", TERMS, ids=["sway", "slow sway", "wander"])
def test_a_sensor_that_moved_has_its_mean_pose_then(term):
    """The pose at later times is the mean over the acquisition: a slow cosine hardly changes its sign, so that zero would be another pose."""
    times = (np.arange(1000) + 0.5) / 1000 * LAST
    later = term.sensor_screws(None, at(LAST + 1.0))[0]
    np.testing.assert_allclose(term.sensor_screws(None, at(*times)).mean(axis=0), later, atol=1e-5)
