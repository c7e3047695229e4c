"""An effect is not named with confidence where something without a name explains the same as well.

Two pulleys of a belt look like a handful of a gear's orders.
"""

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from tests.diagnosis.cases import harmonic
from tests.effects.injected import Flaws, make_cell, on_joint


def two_pulleys(joint, slow, fast):
    """A joint errs with the turns of two pulleys, of which neither goes round a whole number of times in the joint's turn."""
    return Flaws(
        joints=on_joint(
            joint,
            lambda at: (
                4e-4 * np.sin(slow * at.q[:, joint - 1] + 1.0)
                + 3e-4 * np.sin(fast * at.q[:, joint - 1] + 2.0)
            ),
        )
    )


@pytest.mark.parametrize(("joint", "slow", "fast"), [(4, 3.65, 8.41), (2, 2.4, 7.3)])
def test_two_pulleys_are_no_harmonics_of_the_joint(joint, slow, fast):
    """No name at 0.8 or more; where none is given at all, what is left depends on the joint's own angle."""
    for seed in (0, 1):
        cell = make_cell(two_pulleys(joint, slow, fast), seed=seed, poses_per_plane=34)
        content = diagnose(cell.dataset).to_mapping()
        sure = [e["name"] for e in content["effects"] if e["confidence"] >= 0.8]
        assert sure in ([], ["unattributed"])
        if sure:
            assert content["effects"][-1]["depends_on"] == [f"q{joint}"]


def test_a_harmonic_of_the_joint_keeps_its_name():
    """A wave of any order explains as much as the whole order that is there; the name is preferred, and likelier than not."""
    cell, name, target = harmonic(903)
    (effect,) = diagnose(cell.dataset).to_mapping()["effects"]
    assert effect["name"] == name and effect["target"] == target
    assert effect["confidence"] > 0.5
