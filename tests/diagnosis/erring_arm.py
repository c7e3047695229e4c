"""Tracked poses of an arm of which one joint errs, on a base and before an instrument that may err as well."""

from dataclasses import replace

import numpy as np
import pandas as pd

from tests.kinematics import joint_names
from tests.random_scene import make_scene

NOISE = 2e-5  # [m]


def as_it_is(positions):
    """Return positions ``(N, 3)`` [m] unchanged: nothing errs."""
    return positions


def erring_arm(joint, error, *, base=as_it_is, instrument=as_it_is, seed=5, count=90):
    """Return the dataset of tracked poses of an arm that errs.

    Args:
        joint: The joint that errs, from 1.
        error: Its error [rad] over its angles ``(N,)`` [rad].
        base: Where a base that gives way carries positions ``(N, 3)`` [m], in the base frame.
        instrument: What is shown of positions ``(N, 3)`` [m], in the instrument's frame.
        seed: Draws the arm, the poses and the noise.
        count: Number of poses.
    """
    made = make_scene(
        kind="tracker", seed=seed, poses_per_plane=4, noise=NOISE, angle_error=1e-3, length_error=3e-4
    )
    rng = np.random.default_rng(seed)
    low, high = made.dataset.robot.limits.T
    q = rng.uniform(0.8 * low, 0.8 * high, (count, len(low)))
    stood = q.copy()
    stood[:, joint - 1] += error(q[:, joint - 1])
    T = made.truth.T_tracker_base
    points = instrument(base(made.truth.sensor(stood)[:, :3, 3]) @ T[:3, :3].T + T[:3, 3])
    poses = pd.DataFrame(q, columns=joint_names(len(low)))
    poses.insert(0, "pose", np.arange(count))
    shown = points + NOISE * rng.standard_normal(points.shape)
    return replace(made.dataset, poses=poses, points=shown, starts=np.arange(count + 1))
