"""A tracker that moved within a few poses of a boundary of sessions has no sure name: errors of these few poses are the same."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.naming.step_at_boundary import limited_by_boundaries
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.joint_scale import JointScale
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.target_drift import STEP, TargetDrift
from tests.diagnosis.stand_ins import finding_of
from tests.random_scene import make_scene

LEAST, MARGIN = DEFAULTS.naming.least_confidence, DEFAULTS.selection.change_margin


@pytest.fixture(scope="module")
def dataset():
    """Return sixty poses of a tracker whose second session begins with the pose of order 30."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20).dataset
    order = np.arange(60.0)
    return replace(
        dataset, poses=dataset.poses.assign(order=order, session=np.where(order < 30, "one", "two"))
    )


def confidence(effect, dataset):
    """Return the confidence in a finding of 0.9 after the rule."""
    (finding,) = limited_by_boundaries([finding_of(effect, 0.9)], dataset, MARGIN, LEAST)
    return finding.confidence


@pytest.mark.parametrize("order", [2, 5, 26, 29, 30, 31, 35, 55, 59])
def test_a_step_that_few_poses_of_a_session_show_is_doubtful(order, dataset):
    """A step has six coefficients, and fewer than six poses on one side within its session; at the boundary itself there are none."""
    assert confidence(TargetDrift(STEP, order=float(order)), dataset) == 0.5


@pytest.mark.parametrize("order", [6, 15, 24, 36, 45, 54])
def test_a_step_in_the_middle_of_a_session_keeps_its_confidence(order, dataset):
    """With six poses or more on either side, nothing is lowered; nor is it without sessions, where the search keeps this distance from the ends."""
    step = TargetDrift(STEP, order=float(order))
    assert confidence(step, dataset) == 0.9
    without = replace(dataset, poses=dataset.poses.drop(columns="session"))
    assert confidence(TargetDrift(STEP, order=31.0), without) == 0.9


@pytest.mark.parametrize("effect", [JointScale(2), SensorSlip(31.0, None, False)], ids=lambda e: e.name)
def test_other_effects_have_no_place_of_their_own_in_each_session(effect, dataset):
    """A slip of the sensor lasts over the boundary, and all later poses show it."""
    assert confidence(effect, dataset) == 0.9
