"""A rail that is recorded behind the joints of the arm, as an external axis is, and declared before them."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.tables.displaced_column import displaced_ends, displaced_slides, put_back
from tests.rail_and_arm import RailAndArm, poses
from tests.random_scene import make_scene


def test_a_travel_in_the_last_column_is_named():
    """The suspicion says where the travel stands, and the residual falls below a millimetre with it in its own column."""
    rng = np.random.default_rng(4)
    cell, q = RailAndArm.drawn(rng), poses(60, rng)
    dataset = cell.dataset(q, 1e-5, rng)
    recorded = np.column_stack([q[:, 1:], q[:, 0]])
    columns = {f"q{j + 1}": recorded[:, j] for j in range(q.shape[1])}
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(dataset, poses=dataset.poses.assign(**columns)))
    (suspicion,) = refused.value.suspicions
    assert suspicion.rms_after < 1e-3 < suspicion.rms_before
    assert "last column" in suspicion.sentence and "q7" in suspicion.sentence


@pytest.mark.parametrize("place", [0, 4])
@pytest.mark.parametrize("slide", [0, 2, 4])
def test_a_column_is_put_back(place, slide):
    """Whatever order a slide was taken from, putting it back gives the joints in their order."""
    q = np.arange(10.0).reshape(2, 5)
    order = [j for j in range(5) if j != slide]
    order.insert(place, slide)
    assert np.array_equal(put_back(q[:, order], place, slide), q)


def test_an_arm_without_a_slide_may_have_its_first_or_last_joint_elsewhere():
    """Angles in the order q2 to q6, q1 are named; there is no travel to put back."""
    tracked = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    columns = {f"q{j + 1}": tracked.q[:, (j + 1) % 6] for j in range(6)}
    with pytest.raises(WrongSetup, match="the angle of joint 1 stands in the last column"):
        calibrate(replace(tracked, poses=tracked.poses.assign(**columns)))
    assert [one.where for one in displaced_ends(tracked)] == ["joint 1", "joint 6"]
    assert not list(displaced_slides(tracked))
