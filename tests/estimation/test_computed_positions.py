"""Positions that a controller computed from the joint angles are said to be that: they leave a residual that no measurement leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.units import MM
from tests.random_scene import make_scene


def said_of(scatter, noise, poses=75):
    """Return what is suspected of the nominal positions of an arm that scatter by so much [mm]; ``noise`` is what the dataset states [mm]."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset.subset(
        np.arange(poses)
    )
    T = dataset.sensor.T_flange_sensor
    points = (dataset.robot.flange(dataset.q) @ T)[:, :3, 3]
    points = points + np.random.default_rng(4).normal(0.0, scatter * MM, points.shape)
    sensor = replace(dataset.sensor, noise=None if noise is None else noise * MM)
    summary = calibrate(replace(dataset, points=points, sensor=sensor)).summary
    return [s["sentence"] for s in summary["setup"] if s["what"] == "computed"]


@pytest.mark.parametrize("noise", [None, 0.05])
def test_positions_without_any_scatter_are_said_to_be_computed(noise):
    """Half a micrometre is less than any tracker scatters, whatever noise is stated."""
    (sentence,) = said_of(0.0005, noise)
    assert "computed from the joint angles" in sentence and "points.csv" in sentence


@pytest.mark.parametrize(
    ("scatter", "noise", "poses"), [(0.005, None, 75), (0.0005, 0.0005, 75), (0.0005, None, 15)]
)
def test_measured_positions_are_not(scatter, noise, poses):
    """Nothing is said of 5 um, of a noise that the user states to be as small, and of so few poses that a fit may leave nothing."""
    assert not said_of(scatter, noise, poses)
