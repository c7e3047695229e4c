"""Data of an arm that dataset.yaml does not describe are refused with the arm of the library that was measured, whatever the sensor."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.arm import other_arms
from scalar.estimation.setup.arm.far_lengths import far_length_in_words
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.geometry.robot import GEOMETRY
from scalar.robots import arm_names, read_arm
from tests.random_scene import make_scene


def described_as(name, kind):
    """Return data of a UR10e whose dataset.yaml has the table of another arm."""
    dataset = make_scene("ur10e", kind, poses_per_plane=25, points_per_scan=20, seed=6).dataset
    return replace(dataset, robot=read_arm(name).robot)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("tracker", "doosan_m1013"),
        ("tracker", "fanuc_m10ia"),
        ("line-laser", "doosan_m1013"),
    ],
)
def test_the_arm_that_was_measured_is_named(kind, name):
    """A UR10e under the name and table of another arm: the refusal names the UR10e and how to begin its folder, with a corrected table."""
    with pytest.raises(WrongSetup) as refusal:
        calibrate(described_as(name, kind))
    (suspicion,) = refusal.value.suspicions
    assert suspicion.what == other_arms.OTHER_ARM
    assert (
        "'ur10e' of the library" in suspicion.sentence and "scalar init --robot ur10e" in suspicion.sentence
    )
    assert suspicion.robot is not None and suspicion.robot.name == "ur10e"


def test_the_nearest_arm_is_tried():
    """Of all arms of the library with six joints, the one that was measured is proposed, and nothing if none leaves as little as a nominal arm."""
    (alternative,) = other_arms.other_arms(described_as("doosan_m1013", "tracker"))
    assert alternative.dataset.robot.name == "ur10e"
    dataset = described_as("ur5e", "tracker")
    scaled = replace(dataset, points=1.2 * dataset.points)
    assert not list(other_arms.other_arms(scaled))


def test_a_probe_that_shows_no_length_names_the_arm_of_these_proportions():
    """A UR10e under the table of a UR5e, touched with a probe: the answer keeps one length of the table, and says which arm has the proportions."""
    calibration = calibrate(described_as("ur5e", "probe"))
    said = " ".join(entry["sentence"] for entry in calibration.summary["setup"])
    assert "'ur10e' of the library" in said and "all lengths here are wrong by this factor" in said


def test_an_arm_of_another_size_is_no_unit_alone():
    """The links of a UR10e are about 1.4 times as long as those of a UR5e: beside the unit, the arm is named."""
    with pytest.raises(WrongSetup) as refusal:
        calibrate(described_as("ur5e", "tracker"))
    (suspicion,) = refusal.value.suspicions
    assert "times as long as dataset.yaml has them" in suspicion.sentence
    assert (
        "or at the robot: the distances between its axes are those of Universal Robots UR10e"
        in suspicion.sentence
    )


@pytest.mark.slow
def test_no_arm_is_named_that_was_not_measured(monkeypatch):
    """Without the UR10e the library has no arm that fits, and the refusal names none: a similar one is no answer."""
    monkeypatch.setattr(other_arms, "arm_names", lambda: [name for name in arm_names() if name != "ur10e"])
    with pytest.raises(ScalarError) as refusal:
        calibrate(described_as("doosan_m1013", "tracker"))
    assert "scalar init --robot" not in str(refusal.value)


def test_a_far_length_names_the_arm_whose_axes_were_fitted():
    """Under a wrong zero, the table of one arm may fit the measurements of another if its lengths change: the other one is named, if there is one."""
    described, measured = (read_arm(name).robot for name in ("staubli_tx2_90", "abb_irb1200_5_90"))
    said = far_length_in_words(described, replace(described, geometry=measured.geometry))
    assert "'abb_irb1200_5_90' of the library" in said
    stretched = measured.geometry * np.where(np.arange(5) == GEOMETRY.index("a"), 1.7, 1.0)[:, None]
    assert far_length_in_words(described, replace(described, geometry=stretched)).endswith("measured?")
    assert far_length_in_words(measured, measured) == ""
