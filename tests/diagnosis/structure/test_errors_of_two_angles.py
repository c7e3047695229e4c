"""A joint that errs with the sum of two angles, as by a parallel link, has no sure name: the torque of a weight varies with that sum as well."""

import numpy as np
import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.effects.flexible.angle_sum import UnattributedAngleSum
from tests.diagnosis.structure.tracked_workcell import tracked
from tests.effects.injected import Flaws, PoseData


@pytest.mark.parametrize(
    ("robot", "size", "poses", "seed"),
    [("puma560", 3e-4, 60, 1), ("vs060", 3e-4, 240, 2), ("panda", 1.5e-4, 120, 3)],
)
def test_an_error_with_a_sum_of_angles_is_no_compliance(robot, size, poses, seed):
    """Alone, a compliance resembles it; with a scale error and a coupling of the joint it resembles it even more."""

    def parallel_link(at: PoseData) -> np.ndarray:
        errors = np.zeros_like(at.q)
        errors[:, 2] = size * np.sin(0.7 * (at.q[:, 1] + at.q[:, 2]) + 0.2)
        return errors

    found = diagnose(tracked(robot, Flaws(joints=parallel_link), seed, 2e-5, poses))
    assert not [f.effect.name for f in found.findings if f.has_name and f.confidence >= 0.8]
    assert any(isinstance(f.effect, UnattributedAngleSum) and f.effect.joint == 3 for f in found.findings)
