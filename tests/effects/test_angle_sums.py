"""A joint that is wound up by two others is not called a coupling of each of them."""

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis import diagnose
from scalar.effects.flexible.angle_sum import UnattributedAngleSum, sums_with
from scalar.effects.joint_coupling import JointCoupling
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.random_scene import make_scene
from tests.turning import turning


def test_the_sum_and_the_difference_of_each_pair_are_tried():
    """For a coupling from joint 4 there are sums and differences of its angle with that of every other joint, each pair once."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    found = sums_with(dataset, 6, 4)
    assert {(e.of, e.sign) for e in found} == {
        (tuple(sorted((4, j))), sign) for j in (1, 2, 3, 5, 6) for sign in (1, -1)
    }
    assert {e.key for e in found} < {e.key for e in JointCoupling(6, 4).imitators(dataset)}
    assert len({e.key for e in found}) == len(found)


def test_the_term_depends_on_the_sum_alone():
    """Angles that change against one another leave the error as it is; beyond the measured range it stays at that of the end."""
    effect = UnattributedAngleSum(6, (4, 6), 1, 0.0, 2.0)
    q = np.zeros((3, 6))
    q[:, 3], q[:, 5] = [0.3, 1.0, 5.0], [0.5, -0.2, 0.0]
    columns = effect.own_columns(None, Poses.from_arrays(q, {}, turning(6)))
    np.testing.assert_allclose(columns[0], columns[1], atol=1e-12)
    np.testing.assert_allclose(columns[2], 1.0)


def test_a_hose_that_pulls_near_the_ends_of_a_sum_is_no_coupling():
    """An error of joint 6 by tanh of a sum is described as one that varies with it; neither coupling nor scale error is sure."""
    flaws = Flaws(joints=on_joint(6, lambda at: 8e-4 * np.tanh(1.5 * (at.q[:, 3] + at.q[:, 5]))))
    cell = make_cell(flaws, seed=21, poses_per_plane=50, points_per_scan=40)
    found = diagnose(cell.dataset)
    sure = [f.effect.name for f in found.findings if f.has_name and f.confidence >= 0.8]
    assert not {"joint_coupling", "joint_scale"} & set(sure)
    described = [f.effect.described_as for f in found.findings if not f.has_name]
    assert any("sum of the positions of joints 4 and 6" in text for text in described)


def test_a_coupling_is_still_named():
    """A wrist whose gears are coupled is named for sure."""
    flaws = Flaws(joints=on_joint(6, lambda at: 1e-3 * at.q[:, 3]))
    found = diagnose(make_cell(flaws, seed=21, poses_per_plane=50, points_per_scan=40).dataset)
    assert [(f.effect.name, f.effect.target) for f in found.findings] == [
        ("joint_coupling", {"joint": 6, "source": 4})
    ]
    assert found.findings[0].confidence >= 0.8
