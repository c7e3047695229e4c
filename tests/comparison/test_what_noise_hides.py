"""A comparison says what noise and sensors leave open: residuals that are no noise, two kinds of sensors, and what is beyond chance."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.compare import describe_comparison
from scalar.comparison import compare
from scalar.comparison.beyond_chance import most_by_chance
from tests.comparison.arms import LENGTH, arm_before, changed


@pytest.fixture(scope="module")
def before():
    """Return a calibration of an arm, before any change."""
    return arm_before()


def test_two_kinds_of_sensors_are_said_to_be_two(before):
    """Another instrument sits at another place, which is no displacement of the first."""
    assert "sensor_kinds" not in compare(before, before).campaign
    assert before.sensor["kind"] != "probe"
    found = compare(before, replace(before, sensor={**before.sensor, "kind": "probe"}))
    assert found.campaign["sensor_kinds"] == [before.sensor["kind"], "probe"]
    lines = describe_comparison(found)
    assert any(f"A has a {before.sensor['kind']} and B a probe" in line for line in lines)


def test_a_residual_that_is_no_noise_is_said_where_no_noise_is_known(before):
    """A change may hide behind what both models lack: the residual is stated for each calibration that leaves more than instruments scatter by."""
    lines = describe_comparison(compare(before, before), {"B": 5e-4})
    assert any("the model of B leaves 0.500 mm RMS, which is more than noise" in line for line in lines)
    assert not any("leaves" in line for line in describe_comparison(compare(before, before)))


def test_a_difference_called_beyond_chance_is_one_that_chance_seldom_makes():
    """Normal differences along one direction exceed the limit as often as alpha says, and along several directions less often."""
    draws = np.random.default_rng(11).standard_normal((200_000, 3))
    for weights in ([1.0, 0.0, 0.0], [1.0, 0.5, 0.2], [1.0, 1.0, 1.0]):
        rms = np.sqrt((draws**2 @ np.array(weights)) / np.sum(weights))
        share = np.mean(rms > most_by_chance(1.0, 0.01))
        assert share < 0.011
        assert share > 0.009 or weights[1] > 0


def with_estimated_noise(calibration, noise, stated=None):
    """Return a calibration of tracked points whose noise [m] was estimated from the residual, to 5 %; with ``stated``, one whose noise is known."""
    summary = {**calibration.summary, "misfit": 1.0, "misfit_p_value": None if stated is None else 0.5}
    part = {"name": "position_noise", "target": {}, "value": noise, "std": 0.05 * noise, "unit": "m"}
    sensor = {"kind": "tracker"}
    return replace(calibration, noise=(part,), residual_rms=noise * 3**0.5, summary=summary, sensor=sensor)


def test_a_campaign_that_leaves_more_than_the_other_may_lack_something(before):
    """A damaged gear moves estimated lengths, without a change of any length: no change of the arm is claimed, and the note says of which model."""
    quiet, loud = with_estimated_noise(before, 4e-5), with_estimated_noise(before, 8e-5)
    found = compare(quiet, changed(loud, a_3=20 * LENGTH))
    said = describe_comparison(found)
    assert found.noisier == 1 and any(
        "the model of B leaves 0.139 mm RMS, and that of A 0.069 mm" in line for line in said
    )
    assert any("the calibrations differ: 1 difference" in line for line in said)
    assert not any("the arm changed" in line for line in said)


@pytest.mark.parametrize(
    "other",
    [
        lambda c: with_estimated_noise(c, 4.6e-5),
        lambda c: with_estimated_noise(c, 8e-5, stated=8e-5),
        lambda c: c,
    ],
    ids=["chance", "stated", "scanner"],
)
def test_noise_that_differs_by_chance_or_is_known_is_no_lack(before, other):
    """A change between two such campaigns is one of the arm."""
    quiet = with_estimated_noise(before, 4e-5)
    found = compare(quiet, changed(other(before), a_3=20 * LENGTH))
    assert found.noisier is None
    assert any("the arm changed: 1 change" in line for line in describe_comparison(found))
