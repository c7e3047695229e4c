"""A gear that is wound up to a torque, and no further, is not called play, which changes its side at once."""

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis import diagnose
from scalar.effects.flexible.bent_deflection import KNEES
from scalar.effects.flexible.wind_up import UnattributedWindUp, wind_ups
from scalar.effects.gravity import typical_masses
from scalar.effects.joint_backlash import JointBacklash
from tests.effects.injected import Flaws, PoseData, make_cell, shares_of_torque
from tests.random_scene import make_scene

SEED = 28


def loaded(gradual: bool):
    """Return the diagnosis of an arm whose joint 3 moves by 0.4 mrad to the side of its torque: at once, or gradually over 30 % of the torque."""
    truth = make_scene(seed=SEED, poses_per_plane=40).truth

    def joints(at: PoseData) -> np.ndarray:
        share = shares_of_torque(truth, at.q, 3)
        dq = np.zeros_like(at.q)
        dq[:, 2] = 4e-4 * (np.clip(share / 0.3, -1.0, 1.0) if gradual else np.sign(share))
        return dq

    return diagnose(
        make_cell(Flaws(joints=joints), seed=SEED, poses_per_plane=40, points_per_scan=40).dataset
    )


@pytest.mark.parametrize("masses_known", [True, False])
def test_the_column_is_the_torque_up_to_the_knee(masses_known):
    """It grows with the torque from -1 to 1, and has the sign of the play's side everywhere."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    poses = Poses(dataset.q, np.arange(dataset.n_poses, dtype=float), {})
    masses = tuple(map(float, typical_masses(dataset.robot, dataset.q, 2))) if masses_known else ()
    play = JointBacklash(2, "torque", masses)
    found = wind_ups(dataset, 2, masses)
    assert len({effect.key for effect in found}) == len(found) == len(KNEES)
    torque = play.torque(dataset.robot, dataset.q)
    for effect, share in zip(found, KNEES, strict=True):
        columns = effect.joint_basis(dataset.robot, poses)
        ratio = torque / (share * np.abs(torque).max())
        beyond = np.abs(ratio) > 1.0
        assert beyond.any() and not beyond.all()
        np.testing.assert_allclose(columns[~beyond, 1, 0], ratio[~beyond], rtol=1e-12)
        np.testing.assert_array_equal(columns[beyond, 1], play.joint_basis(dataset.robot, poses)[beyond, 1])
        assert not columns[:, [0, 2, 3, 4, 5]].any()


def test_it_is_tried_in_the_place_of_play_by_the_torque_alone():
    """The side of recorded approaches follows from no torque."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset

    def joints(effect):
        return {e.joint for e in effect.imitators(dataset) if isinstance(e, UnattributedWindUp)}

    assert joints(JointBacklash(3, "torque")) == {3}
    assert joints(JointBacklash(3, "moves")) == set()


@pytest.mark.parametrize("gradual", [True, False])
def test_play_has_its_name_only_where_the_side_changes_at_once(gradual):
    """The joint that is wound up is said to be in error, without the name of play; true play of the same size has its name for sure."""
    found = loaded(gradual).findings
    sure = {f.effect.key for f in found if f.has_name and f.confidence >= 0.8}
    assert found
    assert ("joint_backlash_3" in sure) is not gradual
