"""Columns of scans that were exchanged or mirrored are named where a fit has the scanner turned by half a turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from tests.random_scene import make_scene

MISREAD = {
    "the columns x and z of scans.csv may be swapped": lambda points: points[:, ::-1],
    "the column x of scans.csv may count the other way": lambda points: points * [-1.0, 1.0],
    "the column z of scans.csv may count the other way": lambda points: points * [1.0, -1.0],
}


@pytest.fixture(scope="module")
def scans() -> Dataset:
    """Return sixty scans of three planes."""
    return make_scene(
        "vs060", poses_per_plane=20, points_per_scan=12, noise=1e-4, seed=5, error_axis="z"
    ).dataset


@pytest.mark.parametrize("said", MISREAD)
def test_columns_that_were_misread_are_named(scans, said):
    """The residual is that of the noise, and the doubt about the scanner's pose says which columns to look at, and no others."""
    wrong = replace(scans, points=np.ascontiguousarray(MISREAD[said](scans.points)))
    (suspicion,) = calibrate(wrong).summary["setup"]
    assert suspicion["what"] == "sensor_pose" and said in suspicion["sentence"]
    assert sum(other in suspicion["sentence"] for other in MISREAD) == 1


def test_a_scanner_that_sits_turned_by_a_right_angle_has_no_misread_columns(scans):
    """A quarter turn about the ray's axis is a nominal_pose that is wrong, and no exchange of columns."""
    quarter = np.eye(4)
    quarter[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    stated = scans.sensor.T_flange_sensor @ quarter
    (suspicion,) = calibrate(replace(scans, sensor=replace(scans.sensor, T_flange_sensor=stated))).summary[
        "setup"
    ]
    assert suspicion["what"] == "sensor_pose"
    assert not any(said in suspicion["sentence"] for said in MISREAD)
