"""More than three joints that count the other way are named, on an arm that no smaller set of signs imitates."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.arm.several_signs import many_signs
from scalar.estimation.setup.suspicion import WrongSetup
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def tracked() -> Dataset:
    """Return seventy-five tracked poses of an arm whose shoulder and forearm have offsets."""
    base = ("a_1", "alpha_1", "d_1", "theta_1")
    return make_scene("large_arm", "tracker", poses_per_plane=25, noise=1e-4, seed=7, exact=base).dataset


@pytest.mark.slow
@pytest.mark.parametrize("joints", [(1, 2, 3, 6), (2, 3, 4, 5), (1, 3, 4, 5, 6)])
def test_four_or_five_wrong_signs_are_named_together(tracked, joints):
    """All of them stand in one sentence, and no smaller set is named in their place."""
    changed = {f"q{j}": -tracked.q[:, j - 1] for j in joints}
    with pytest.raises(WrongSetup) as refused:
        calibrate(replace(tracked, poses=tracked.poses.assign(**changed)))
    *first, last = map(str, joints)
    (suspicion,) = refused.value.suspicions
    assert suspicion.where == f"joints {', '.join(first)} and {last}"


def test_every_set_of_more_than_three_signs_is_one_reading(tracked):
    """Fifteen sets of four joints, six of five, and all."""
    where = [reading.where for reading in many_signs(tracked)]
    assert len(where) == len(set(where)) == 15 + 6 + 1
    assert where[-1] == "all joints"
