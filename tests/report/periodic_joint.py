"""A diagnosis that the tests of the report share: one joint errs periodically, and the names in the dataset try to break out of a page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from tests.random_scene import make_scene

JOINT, ORDER, AMPLITUDE, PHASE = 4, 3, 6e-4, 0.7
"""The injected harmonic: joint (from 1), order, amplitude [rad] and phase [rad]."""
HOSTILE = "</title><script>alert(1)</script>"
HOSTILE_PLANE = "\"><img src=//x onerror='alert(1)'>&"
OF_RESIDUAL = r'aria-label="[^"]* in order of acquisition'
"""Pattern by which a page's pictures of the residual are found."""


def injected(q: np.ndarray) -> np.ndarray:
    """Return the error of the joint's angle at encoder angles [rad]."""
    return AMPLITUDE * np.sin(ORDER * q + PHASE)


def hostile(dataset: Dataset) -> Dataset:
    """Return a dataset whose names try to break out of the page."""
    renamed = replace(dataset.planes[0], name=HOSTILE_PLANE)
    poses = dataset.poses.copy()
    poses["plane"] = poses["plane"].replace({dataset.planes[0].name: HOSTILE_PLANE})
    robot = replace(dataset.robot, name=HOSTILE)
    return replace(dataset, name=HOSTILE, robot=robot, planes=(renamed, *dataset.planes[1:]), poses=poses)


def harmonic_dataset() -> Dataset:
    """Return a dataset of an arm of which one joint errs periodically."""
    dataset = make_scene(seed=3, poses_per_plane=45, points_per_scan=30).dataset
    poses = dataset.poses.copy()
    # The encoder reads q when the arm is at q + injected(q), which is solved by iteration.
    true = poses[f"q{JOINT}"].to_numpy()
    read = true.copy()
    for _ in range(20):
        read = true - injected(read)
    poses[f"q{JOINT}"] = read
    return replace(dataset, poses=poses)
