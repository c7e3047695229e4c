"""Arms of which some joints err along their own angle by a sum of bumps, which needs many orders to be described."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.random_scene import make_scene

TRACKER_NOISE = 2e-5  # m

BUMP_WIDTH = 0.12  # rad

BUMP_SIZE = 4e-4  # rad

BUMPY_JOINTS = (2, 3)  # joints, from 1


def bumps(seed):
    """Return the error [rad] of a joint at its angles [rad]: a sum of bumps that is not periodic."""
    rng = np.random.default_rng(seed)
    centres = np.arange(-7.0, 7.0, BUMP_WIDTH)
    heights = BUMP_SIZE * rng.standard_normal(len(centres))
    return lambda x: np.exp(-(((x[:, None] - centres) / BUMP_WIDTH) ** 2)) @ heights


def bumpy(seed, poses_per_plane=700, erring=BUMPY_JOINTS, landscape=None):
    """Return a tracked arm of which some joints err: at a true angle q, the encoder reads e with ``e + error(e) = q``.

    Args:
        seed: Seed of the workcell.
        poses_per_plane: A third of the number of poses.
        erring: The joints that err, from 1.
        landscape: Seed of the errors; that of the workcell by default.
    """
    scene = make_scene(kind="tracker", seed=seed, poses_per_plane=poses_per_plane, noise=TRACKER_NOISE)
    read = scene.dataset.q.copy()
    for joint in erring:
        error, stood = (
            bumps(100 * (seed if landscape is None else landscape) + joint),
            read[:, joint - 1].copy(),
        )
        for _ in range(20):
            read[:, joint - 1] = stood - error(read[:, joint - 1])
    columns = {f"q{j}": read[:, j - 1] for j in erring}
    return replace(scene.dataset, poses=scene.dataset.poses.assign(**columns))
