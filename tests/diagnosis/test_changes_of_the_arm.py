"""What changes on the arm itself at one moment, or gives way across an axis, is described as such: it is no knocked tracker, no warmth and no base.

The tracker here stands still, no length grows, and the base is stiff.
"""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis.diagnose import diagnose
from scalar.effects.flexible.arm_step import UnattributedArmStep
from scalar.effects.flexible.load_step import UnattributedLoadStep
from scalar.effects.flexible.tilt import UnattributedTilt
from scalar.units import MM
from tests.effects.injected import ALPHA, A, Flaws, PoseData, true_frames
from tests.kinematics import rotation, translation
from tests.random_scene import make_scene

STEP = 60  # the first pose after the change
NOISE = 0.03 * MM
SEEDS = [500, *(pytest.param(s, marks=pytest.mark.slow) for s in (501, 502))]


def tracked(flaws: Flaws, seed: int, moved: dict[int, float] | None = None) -> Dataset:
    """Return 120 poses before a tracker.

    Args:
        flaws: What is wrong with the arm.
        seed: Of everything.
        moved: ``{pose: by how much a wrong reading is off [m]}``.
    """
    scene = make_scene(
        "vs060", "tracker", seed=seed, poses_per_plane=40, noise=NOISE, length_error=5e-4, angle_error=1e-3
    )
    data, truth = scene.dataset, scene.truth
    at = PoseData(data.q, np.arange(data.n_poses, dtype=float), {})
    place = true_frames(truth, flaws, at, np.zeros_like(data.q))[:, :3, 3]
    points = place @ truth.T_tracker_base[:3, :3].T + truth.T_tracker_base[:3, 3]
    points += NOISE * np.random.default_rng([seed, 5]).standard_normal(points.shape)
    for pose, by in (moved or {}).items():
        points[pose] += by / np.sqrt(3.0)
    order = np.arange(data.n_poses, dtype=float)
    return replace(data, points=points, poses=data.poses.assign(order=order))


def levers(data_q: np.ndarray, truth, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the arm ``(N, 3)`` from a joint (from 1) to the flange, and the joint's axis ``(N, 3)``, base frame."""
    T = np.broadcast_to(truth.T_base_0, (len(data_q), 4, 4))
    g, frames = truth.geometry, []
    for i in range(data_q.shape[1]):
        T = (
            T
            @ rotation(0, g[ALPHA, i])
            @ translation(0, g[A, i])
            @ rotation(2, data_q[:, i] + g[3, i])
            @ translation(2, g[2, i])
        )
        frames.append(T)
    flange = T @ truth.T_n_flange
    return flange[:, :3, 3] - frames[joint - 1][:, :3, 3], frames[joint - 1][:, :3, 2]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_link_that_was_bent_is_described(seed):
    """A crash changes one length and one twist: neither a tracker that was knocked nor warmth is named."""

    def bent(at: PoseData) -> np.ndarray:
        change = np.zeros((len(at.q), 5, at.q.shape[1]))
        change[at.order >= STEP, A, 2], change[at.order >= STEP, ALPHA, 2] = 0.3 * MM, 4e-4
        return change

    found = diagnose(tracked(Flaws(geometry=bent), seed))
    assert found.verdict == "unattributed"
    assert not [f.effect.name for f in found.findings if f.has_name]
    (term,) = [f.effect for f in found.findings if isinstance(f.effect, UnattributedArmStep)]
    assert term.joints == (3,) and f"from about order {STEP} on" in term.described_as


@pytest.mark.parametrize("seed", SEEDS)
def test_a_load_that_nobody_recorded_is_described(seed):
    """From one pose on the flange carries a part: joints 2 and 3 give way by up to 0.4 mrad, and no tracker is said to have moved."""
    truth = make_scene("vs060", "tracker", seed=seed, poses_per_plane=3).truth

    def sag(at: PoseData) -> np.ndarray:
        errors = np.zeros_like(at.q)
        for joint, compliance in ((2, 8e-4), (3, 1.2e-3)):
            arm, axis = levers(at.q, truth, joint)
            errors[:, joint - 1] = (
                compliance * np.sum(np.cross(arm, [0.0, 0.0, -1.0]) * axis, axis=1) * (at.order >= STEP)
            )
        return errors

    found = diagnose(tracked(Flaws(joints=sag), seed))
    assert "target_drift" not in [f.effect.name for f in found.findings if f.has_name]
    (term,) = [f.effect for f in found.findings if isinstance(f.effect, UnattributedLoadStep)]
    assert {2, 3} <= set(term.joints)
    assert any("payload" in sentence for sentence in term.advice)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_bearing_that_gives_way_across_its_axis_is_described(seed):
    """The axis of joint 3 tilts by up to 0.6 mrad as the weight behind it tips: neither base nor other joints are said to give way."""
    truth = make_scene("vs060", "tracker", seed=seed, poses_per_plane=3).truth

    def tilted(at: PoseData) -> np.ndarray:
        arm, axis = levers(at.q, truth, 3)
        tipping = np.cross(arm, [0.0, 0.0, -1.0])
        T = np.broadcast_to(truth.T_base_0, (len(at.q), 4, 4))
        for i in range(2):
            T = T @ rotation(0, truth.geometry[ALPHA, i]) @ translation(0, truth.geometry[A, i])
            T = T @ rotation(2, at.q[:, i] + truth.geometry[3, i]) @ translation(2, truth.geometry[2, i])
        x = (T @ rotation(0, truth.geometry[ALPHA, 2]))[:, :3, 0]
        across = np.stack([np.sum(tipping * x, axis=1), np.sum(tipping * np.cross(axis, x), axis=1)], axis=1)
        size = np.linalg.norm(across, axis=1, keepdims=True)
        change = np.zeros((len(at.q), 5, at.q.shape[1]))
        change[:, (ALPHA, 4), 2] = 6e-4 * across / (size + 0.05)
        return change

    found = diagnose(tracked(Flaws(geometry=tilted), seed))
    named = [f.effect.name for f in found.findings if f.has_name and f.confidence >= 0.8]
    assert "base_compliance" not in named and "joint_compliance" not in named
    assert any(isinstance(f.effect, UnattributedTilt) and f.effect.joint == 3 for f in found.findings)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wrong_reading_is_no_tracker_that_was_knocked_and_knocked_back(seed):
    """Two successive readings that are off alike are set aside; what remains has no effect, and its noise is right."""
    found = diagnose(tracked(Flaws(), seed, {70: 0.8 * MM, 71: 0.8 * MM}))
    assert set(found.cleaned.outlier_poses) == {
        int(found.dataset.pose_ids[70]),
        int(found.dataset.pose_ids[71]),
    }
    assert not found.findings
    assert found.calibration_after.residual_rms < 1.2 * np.sqrt(3.0) * NOISE
