"""One coordinate of the measured positions too long: it is named, and no effect of the arm has a confidence of more than one half."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scalar.diagnosis.diagnose import diagnose
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.sensor.stretched_axis import STRETCHED_AXIS
from tests.tracked_targets import drawn_arm


def measured(seed, q_error=0.0):
    """Return 70 positions of a target before a tracker; joint 2 errs by some radians a radian."""
    rng = np.random.default_rng(seed)
    arm = drawn_arm(rng, ("A",))
    q = arm.poses(70, rng)
    true = q.copy()
    true[:, 1] += q_error * q[:, 1]
    return arm.dataset(q, rng, noise=3e-5, q_true=true, stated={"noise": 3e-5})


def stretched(dataset, axis, factor):
    """Return the dataset with one coordinate of its points multiplied."""
    factors = np.ones(3)
    factors["xyz".index(axis)] = factor
    return replace(dataset, points=dataset.points * factors)


def said_of(calibration):
    """Return the sentences on a stretched coordinate."""
    return [one["sentence"] for one in calibration.summary["setup"] if one["what"] == STRETCHED_AXIS]


@pytest.mark.parametrize(
    ("axis", "factor", "words"),
    [("z", 1.002, "z of points.csv is 0.2 % too long"), ("x", 0.998, "x of points.csv is 0.2 % too short")],
)
def test_the_coordinate_and_its_factor_are_named(axis, factor, words):
    (sentence,) = said_of(calibrate(stretched(measured(3), axis, factor)))
    assert words in sentence


@pytest.mark.parametrize(("seed", "axis"), [(3, "z"), (5, "x"), (8, "y")])
def test_what_it_says_beside_the_stated_errors_covers_what_it_does_to_predictions(seed, axis):
    """Predicted positions of fresh poses, fitted onto those of the true coordinates by a rigid motion, err by no more, and not by far less."""
    dataset = measured(seed)
    wrong, right = calibrate(stretched(dataset, axis, 1.002)), calibrate(dataset)
    (sentence,) = said_of(wrong)
    stated = float(re.search(r"reckon with ([\d.]+) mm", sentence)[1])
    q = drawn_arm(np.random.default_rng(seed), ("A",)).poses(200, np.random.default_rng(seed + 100))
    a, b = (each.predict(q)[:, :3, 3] for each in (wrong, right))
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    rotation, _ = Rotation.align_vectors(b, a)
    found = 1e3 * np.sqrt(np.mean(np.sum((rotation.apply(a) - b) ** 2, axis=1)))
    assert 0.3 * stated < found < 1.3 * stated


def test_a_factor_on_all_coordinates_an_arm_with_an_error_and_a_sound_one_have_no_such_suspicion():
    """The first is one of all lengths of the arm; the second moves its links as no coordinate does."""
    for dataset in (replace(measured(3), points=1.002 * measured(3).points), measured(3, 2e-3), measured(3)):
        assert not said_of(calibrate(dataset))


def test_no_name_of_the_arm_is_sure_beside_it():
    """Effects of the arm may come near to a longer coordinate; they are said to be no more than resemblances."""
    found = diagnose(stretched(measured(5), "z", 1.002))
    assert said_of(found.calibration_before)
    assert all(one.confidence <= 0.5 for one in found.findings if not one.effect.flexible)
