"""Scenes that the tests of the baseline share."""

from __future__ import annotations

import numpy as np

from tests.random_scene import make_scene
from tests.workcell import Scene

TILTED_SEED = 2  # both walls lean by more than a degree, one of them downwards


def scene_with_guesses(robot: str, upright: bool, poses_per_plane: int) -> Scene:
    """Return a scene with initial guesses of the planes half a degree and 1 cm off.

    Args:
        robot: Name in ``configs/robots``.
        upright: Whether the walls stand upright, where the root is undefined next to the solution; else they lean.
        poses_per_plane: Poses on each plane.
    """
    return make_scene(
        robot,
        seed=TILTED_SEED,
        poses_per_plane=poses_per_plane,
        points_per_scan=20,
        noise=1e-5,
        upright=upright,
        plane_tilt=np.deg2rad(0.5),
        plane_offset=0.01,
        length_error=1e-3,
        angle_error=np.deg2rad(0.3),
    )
