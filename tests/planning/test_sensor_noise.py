"""The noise for which poses are planned is that of the sensor as far as anything shows it."""

from dataclasses import replace

import pytest

from scalar.estimation.result import Calibration
from scalar.planning.sensor_noise import with_noise
from tests.random_scene import make_scene


@pytest.mark.parametrize(
    ("stated", "estimated", "expected"),
    [(3e-5, 2e-5, 3e-5), (None, 2e-5, 2e-5), (None, None, 1e-4)],
)
def test_a_stated_noise_comes_before_an_estimated_one_and_that_before_the_usual(stated, estimated, expected):
    """The stated noise is used if there is one, else the one that a calibration estimated, and else the usual noise of the kind."""
    dataset = make_scene(kind="tracker", poses_per_plane=3).dataset
    calibration = replace(
        Calibration.nominal(dataset), summary={} if estimated is None else {"sigma_m": estimated}
    )
    sensor = replace(dataset.sensor, noise=stated)
    assert with_noise(sensor, calibration).noise == pytest.approx(expected)
