"""The shift of the sensor on its flange has a standard error, and chance is called chance."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.comparison.sensor_shift import SensorShift
from scalar.geometry.robot import Robot
from scalar.units import MM
from tests.calibrated_arms import calibrated
from tests.robot_configs import robot_mapping

PLACE = ("sensor_x", "sensor_y", "sensor_z")
STD = np.array([0.02, 0.05, 0.01]) * MM


def campaign(rng=None, **by):
    """Return a calibration with these errors of the sensor's place, drawn where a generator is given, and with larger parameters."""
    made = calibrated(Robot.from_mapping(robot_mapping("vs060")), np.random.default_rng(1))
    vector = made.model.vector.copy()
    drawn = {} if rng is None else dict(zip(PLACE, STD * rng.standard_normal(3), strict=True))
    for name, step in (*drawn.items(), *by.items()):
        vector[made.model.names.index(name)] += step
    covariance = np.diag(np.r_[1e-5, STD]) ** 2
    return replace(made, model=made.model.with_vector(vector), free=("a_3", *PLACE), covariance=covariance)


@pytest.mark.parametrize(("name", "std"), list(zip(PLACE, STD, strict=True)))
def test_a_shift_has_the_standard_errors_of_both_along_it(name, std):
    """Along one axis, the variances of both campaigns add; a shift of many standard errors is beyond chance."""
    found = SensorShift.between(campaign(), campaign(**{name: 1 * MM}))
    assert found.distance == pytest.approx(1 * MM)
    assert found.std == pytest.approx(np.sqrt(2.0) * std)
    assert found.p_value is not None and found.p_value < 1e-6


def test_chance_is_beyond_chance_as_often_as_stated():
    """Of 400 pairs of campaigns without a shift, about a tenth have a p-value below 0.1, by a binomial bound of four standard deviations."""
    rng = np.random.default_rng(4)
    p = np.array([SensorShift.between(campaign(rng), campaign(rng)).p_value for _ in range(400)])
    assert abs(np.mean(p < 0.1) - 0.1) < 4 * np.sqrt(0.1 * 0.9 / 400)


def test_different_fixed_parameters_state_no_error():
    """If only one of them fixed a parameter of the arm, the places are not those of the same flange."""
    later = campaign(sensor_x=1 * MM)
    fixed = replace(later, free=later.free[1:], covariance=later.covariance[1:, 1:])
    found = SensorShift.between(campaign(), fixed)
    assert found.distance == pytest.approx(1 * MM) and found.std is None and found.p_value is None
