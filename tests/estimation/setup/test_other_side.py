"""Poses that lie as far to one side of their planes are told from gross errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.planes.other_side import other_side
from scalar.units import MM
from tests.random_scene import make_scene

OFF = np.arange(0, 75, 5)  # rows


@pytest.fixture(scope="module")
def scene():
    """Return seventy-five scans, which of them are off, the model of the others, and the height that a unit along z of the scanner has."""
    made = make_scene(seed=7, poses_per_plane=25, points_per_scan=12, noise=1e-4)
    dataset = made.dataset
    off = np.isin(np.arange(dataset.n_poses), OFF)
    facing = np.sum(made.truth.sensor(dataset.q)[:, :3, 2] * made.truth.normals[dataset.plane_index], axis=1)
    return dataset, off, calibrate(dataset.subset(~off)).model, facing


def lifted(dataset, heights):
    """Return the dataset whose scans see their planes so much farther away ``(N,)`` [m], along z of the scanner."""
    points = dataset.points.copy()
    points[:, 1] += np.repeat(heights, np.diff(dataset.starts))
    return replace(dataset, points=points)


def test_scans_of_another_surface_are_told(scene):
    """Scans that all lie five millimetres in front of their planes are said to be of another surface."""
    dataset, off, model, facing = scene
    found = other_side(
        lifted(dataset, np.where(off, 5 * MM / facing, 0.0)), dataset.pose_ids[off].tolist(), model
    )
    assert found is not None and found.what == "other_side"
    assert (
        f"of the {off.sum()} poses that were set aside" in found.sentence
        and "their planes: was another surface" in found.sentence
    )


def test_gross_errors_are_not(scene):
    """Errors of several sizes and both signs are no other surface; nor are a few, nor those of a tracker."""
    dataset, off, model, facing = scene
    ids = dataset.pose_ids[off].tolist()
    rng = np.random.default_rng(1)
    scattered = lifted(dataset, np.where(off, rng.uniform(-20, 20, len(off)) * MM, 0.0))
    assert other_side(scattered, ids, model) is None
    assert other_side(lifted(dataset, np.where(off, 5 * MM / facing, 0.0)), ids[:3], model) is None
    tracked = make_scene("vs060", "tracker", seed=7, poses_per_plane=10, noise=1e-4).dataset
    assert other_side(tracked, tracked.pose_ids[:8].tolist(), calibrate(tracked).model) is None
