"""The travel of a rail in another unit than it is read in is named with both units."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.arm.slide_units import slide_units
from scalar.estimation.setup.suspicion import WrongSetup
from tests.rail_and_arm import RailAndArm, poses
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def measured():
    """Return an arm on a rail before a tracker."""
    rng = np.random.default_rng(14)
    cell, q = RailAndArm.drawn(rng), poses(60, rng)
    return cell.dataset(q, 1e-5, rng)


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (0.1, "10 times too small, as centimetres are that were taken for millimetres"),
        (25.4, "25.4 times too large, as millimetres are that were taken for inches"),
        (1e-3, "1000 times too small, as metres are that were taken for millimetres"),
    ],
)
def test_the_unit_of_a_travel_is_named(measured, times, words):
    """The other joints set the scale, so that it is this column that is wrong."""
    wrong = replace(measured, poses=measured.poses.assign(q1=times * measured.q[:, 0]))
    with pytest.raises(WrongSetup) as refused:
        calibrate(wrong)
    (suspicion,) = refused.value.suspicions
    assert words in suspicion.sentence and suspicion.file_at_fault == "poses.csv"
    assert suspicion.rms_after < 1e-3 < suspicion.rms_before


def test_each_factor_is_tried_once_and_only_for_a_joint_that_slides_and_moves(measured):
    factors = [np.ptp(one.dataset.q[:, 0]) / np.ptp(measured.q[:, 0]) for one in slide_units(measured)]
    assert len(factors) == len(np.unique(np.round(np.log(factors), 6)))
    assert not any(np.isclose(factors, 1.0))
    assert not list(slide_units(replace(measured, poses=measured.poses.assign(q1=0.5))))
    assert not list(slide_units(make_scene("vs060", "tracker", poses_per_plane=4).dataset))
