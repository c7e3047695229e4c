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


@pytest.mark.parametrize("term", [UnattributedSway(TIME, 2.5), UnattributedWander(TIME, "x")])
def test_it_is_zero_before_the_acquisition_and_from_its_end_on(term):
    """A time that is not given stands for the end."""
    screws = term.sensor_screws(None, at(-1.0, LAST, LAST + 1.0, np.nan, 20.0))
    assert not screws[:4].any()
    assert screws[4].any()


def test_a_wandering_sensor_has_its_mean_pose_then():
    """The mean of all half waves over the acquisition is zero, which is their value at later times."""
    times = (np.arange(1000) + 0.5) / 1000 * LAST
    np.testing.assert_allclose(
        UnattributedWander(TIME, "x").sensor_screws(None, at(*times)).mean(axis=0), 0.0, atol=1e-12
    )
