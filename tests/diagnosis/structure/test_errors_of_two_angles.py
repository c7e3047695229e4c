"""A joint that errs with the sum of two angles, as by a parallel link, has no sure name: the torque of a weight varies with that sum as well."""

import numpy as np
import pandas as pd
import pytest

from scalar.diagnosis.diagnose import diagnose
from scalar.effects.flexible.angle_sum import UnattributedAngleSum
from scalar.evaluate import evaluate
from tests.diagnosis.structure.tracked_workcell import tracked, workcell
from tests.effects.injected import Flaws, PoseData, true_frames
from tests.kinematics import joint_names, rotation_vector


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


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_the_correction_does_no_harm_beside_the_measured_range(seed):
    """A spring between carousel and forearm turns joint 2 by up to half a milliradian. Up to 0.3 rad beyond the ranges of the joints that were
    measured, the corrected model errs by no more than the one without effects.
    """

    def spring(at: PoseData) -> np.ndarray:
        """Return the error of joint 2, which is the moment of the spring's force, whose free length is 0.5."""
        upper, lower = at.q[:, 1], at.q[:, 1] + at.q[:, 2]
        end = np.stack([np.sin(upper) + 0.3 * np.sin(lower), np.cos(upper) + 0.3 * np.cos(lower)])
        along = end - np.array([[0.2], [-0.3]])
        length = np.linalg.norm(along, axis=0)
        moment = (length - 0.5) * (end[0] * along[1] - end[1] * along[0]) / length
        errors = np.zeros_like(at.q)
        errors[:, 1] = 5e-4 * moment / np.abs(moment).max()
        return errors

    flaws, scene = Flaws(joints=spring), workcell("ur10e", seed, 1e-5, 60)
    found = diagnose(tracked("ur10e", flaws, seed, 1e-5, 60))
    q = scene.dataset.q
    beyond = np.random.default_rng(seed).uniform(q.min(axis=0) - 0.3, q.max(axis=0) + 0.3, (300, q.shape[1]))
    at = PoseData(beyond, np.zeros(len(beyond)), {})
    true = true_frames(scene.truth, flaws, at, np.zeros_like(beyond))
    names = ["pose", *joint_names(q.shape[1]), "x", "y", "z", "rx", "ry", "rz"]
    values = np.column_stack(
        [np.arange(len(beyond)), beyond, true[:, :3, 3], rotation_vector(true[:, :3, :3])]
    )
    table = pd.DataFrame(values, columns=names).astype({"pose": int})
    errors = [
        evaluate(c, table).aligned.position.mean()
        for c in (found.calibration_before, found.calibration_after)
    ]
    assert errors[1] < errors[0]
