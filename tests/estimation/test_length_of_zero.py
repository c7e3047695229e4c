"""A link whose length is missing in the table of joints makes two axes one there; the calibration is that of the right table all the same."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.geometry.robot import GEOMETRY
from tests.random_scene import make_scene

A = GEOMETRY.index("a")


@pytest.mark.parametrize("seed", [3, 4])
def test_a_length_typed_as_zero_is_found_with_everything_else(seed):
    """With a_3 of 0 in place of some 305 mm, axes 2 and 3 coincide; parameters that are free, and residual, are those of the right table."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=2e-5, seed=seed).dataset
    geometry = dataset.robot.geometry.copy()
    length, geometry[A, 2] = geometry[A, 2], 0.0
    right = calibrate(dataset)
    found = calibrate(replace(dataset, robot=dataset.robot.with_geometry(geometry)))
    assert set(found.free) == set(right.free)
    assert found.residual_rms == pytest.approx(right.residual_rms, rel=1e-3)
    assert found.model.robot.geometry[A, 2] == pytest.approx(length, abs=0.01)
    assert [s["where"] for s in found.summary["setup"]] == ["a_3"]
    q = np.random.default_rng(1).uniform(-1, 1, (50, 6))
    apart = np.linalg.norm(found.predict(q)[:, :3, 3] - right.predict(q)[:, :3, 3], axis=1)
    assert np.ptp(apart) < 0.1e-3  # the base, which a tracker does not show, may be elsewhere
