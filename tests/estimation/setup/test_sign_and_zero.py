"""A joint whose sign and zero are wrong together is named, with its angle as it should be read, and a table that makes it right."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.units import DEG, MM
from tests.random_scene import make_scene


def spoilt(dataset: Dataset, joint: int, zero: float) -> Dataset:
    """Return the dataset with a joint (from 1) that counts the other way, from ``zero`` [rad]: its angle is ``-q + zero``."""
    return replace(dataset, poses=dataset.poses.assign(**{f"q{joint}": zero - dataset.q[:, joint - 1]}))


@pytest.mark.parametrize(
    ("kind", "joint", "degrees"),
    [
        ("tracker", 2, -90),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("tracker", 3, 90),
                ("tracker", 3, 75),
                ("tracker", 2, 180),
                ("line-laser", 2, -90),
                ("probe", 3, 90),
            )
        ),
    ],
)
def test_a_sign_and_a_zero_of_one_joint_are_named_together(kind, joint, degrees):
    """The joint and its zero are named, and the corrected table explains the data as they are."""
    sound = make_scene("vs060", kind, poses_per_plane=25, points_per_scan=12, noise=1e-4, seed=7).dataset
    wrong = spoilt(sound, joint, degrees * DEG)
    with pytest.raises(WrongSetup) as refused:
        calibrate(wrong)
    named = {suspicion.where: suspicion for suspicion in refused.value.suspicions}
    suspicion = named[f"joint {joint}"]
    assert suspicion.what == "sign_and_zero" and "the residual falls from" in suspicion.sentence
    off = float(re.search(r"its zero is off by (\S+) degrees", suspicion.sentence)[1])
    assert abs((off - degrees + 180) % 360 - 180) < 2.0  # a joint's own zero error is a degree or so
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.5 * MM
    assert suspicion.robot is not None  # so that the command offers a corrected dataset.yaml
    assert calibrate(replace(wrong, robot=suspicion.robot)).residual_rms < 1 * MM


@pytest.mark.slow
def test_a_wrong_sign_alone_is_not_called_a_sign_and_a_zero():
    """A zero that is off by a few degrees, together with a wrong sign, is an error of the arm, not of the set-up."""
    sound = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    for joint in (2, 4):
        with pytest.raises(WrongSetup) as refused:
            calibrate(spoilt(sound, joint, 3 * DEG))
        assert {suspicion.what for suspicion in refused.value.suspicions} == {"joint_sign"}
