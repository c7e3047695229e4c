"""An effect is not named with confidence if something without a name explains the same equally well.

The two pulleys of a belt resemble a few of a gear's orders; a sensor whose place wanders resembles one that slipped once.
"""

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from tests.diagnosis.cases import harmonic
from tests.effects.injected import Flaws, make_cell, on_joint, true_frames


def two_pulleys(joint, slow, fast):
    """A joint errs with the turns of two pulleys, neither of which makes a whole number of turns in one turn of the joint."""
    return Flaws(
        joints=on_joint(
            joint,
            lambda at: (
                4e-4 * np.sin(slow * at.q[:, joint - 1] + 1.0)
                + 3e-4 * np.sin(fast * at.q[:, joint - 1] + 2.0)
            ),
        )
    )


@pytest.mark.parametrize(
    ("joint", "slow", "fast"), [pytest.param(4, 3.65, 8.41, marks=pytest.mark.slow), (2, 2.4, 7.3)]
)
def test_two_pulleys_are_no_harmonics_of_the_joint(joint, slow, fast):
    """No name has a confidence of 0.8 or more; if there is no name at all, the structure depends on the joint's own angle."""
    for seed in (0, 1):
        cell = make_cell(two_pulleys(joint, slow, fast), seed=seed, poses_per_plane=34)
        content = diagnose(cell.dataset).to_mapping()
        sure = [e["name"] for e in content["effects"] if e["confidence"] >= 0.8]
        assert sure in ([], ["unattributed"])
        if sure:
            assert content["effects"][-1]["depends_on"] == [f"q{joint}"]


def test_a_harmonic_of_the_joint_keeps_its_name():
    """A wave of any order explains as much as the injected whole order; the name is preferred, with a confidence above one half."""
    cell, name, target = harmonic(903)
    (effect,) = diagnose(cell.dataset).to_mapping()["effects"]
    assert effect["name"] == name and effect["target"] == target
    assert effect["confidence"] > 0.5


def wandering(truth, seed):
    """The sensor moves along its own z axis by about 0.2 mm, a random walk that is pulled back within 40 poses."""
    steps = np.random.default_rng(seed).standard_normal(1000)
    walk = np.zeros(1000)
    for k in range(1, 1000):
        walk[k] = np.exp(-1 / 40) * walk[k - 1] + np.sqrt(1 - np.exp(-2 / 40)) * steps[k]

    def motion(at):
        T = true_frames(truth, Flaws(), at, np.zeros_like(at.q))
        M = np.tile(np.eye(4), (len(T), 1, 1))
        M[:, :3, 3] = T[:, :3, 2] * 2e-4 * walk[at.order.astype(int)][:, None]
        return M

    return Flaws(base=motion)


@pytest.mark.slow
def test_a_sensor_that_wanders_has_not_slipped():
    """No name has a confidence of 0.8 or more in three of four walks at least, because a random walk explains as much as one step.

    In one of ten walks a step explains nearly as much as a walk beside two harmonics that the walk imitates, and is a slip with 0.91.
    """
    sure = []
    for seed in range(4):
        truth = make_cell(seed=seed, poses_per_plane=3).scene.truth
        cell = make_cell(wandering(truth, seed), seed=seed, poses_per_plane=34)
        found = diagnose(cell.dataset).to_mapping()["effects"]
        sure.append([e["name"] for e in found if e["confidence"] >= 0.8 and e["name"] != "unattributed"])
    assert sum(bool(names) for names in sure) <= 1
