"""Why a parameter is fixed is said in a sentence."""

import numpy as np

from scalar.estimation.fixed_parameter import explain

NAMES = ("theta_6", "sensor_x", "sensor_y", "sensor_rz")


def fixed(*direction):
    """Return why theta_6 is fixed if a change of it by one is taken up by these changes of the others."""
    return explain(NAMES, 0, np.array([1.0, *direction]), [], {}, "structural")


def test_a_short_lever_takes_up_an_angle():
    """A probe whose tip stands 12 and 8 mm off the last axis: a turn about the axis only shifts the tip, by little for each radian."""
    found = fixed(0.008, -0.012, 0.0)
    assert found.moves_with == ("sensor_y", "sensor_x")
    assert found.reason == "only its combination with sensor_y and sensor_x is determined"


def test_rounding_errors_take_up_nothing():
    """A tip on the axis itself does not move, and a component of the size of rounding errors is not named."""
    found = fixed(1e-12, 0.0, 1e-13)
    assert found.moves_with == () and found.reason == "no residual depends on it"


def test_lengths_are_not_named_beside_an_angle_that_takes_it_up():
    """Where the orientation of the sensor is measured, it is what takes the change up."""
    assert fixed(0.001, 0.0, -1.0).moves_with == ("sensor_rz",)
