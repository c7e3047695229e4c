"""What is said of a set-up fits the kind of sensor: nobody is sent to scans, planes or labels that a tracker does not have."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from scalar.data.sensor_formats import sensor_formats
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.alternatives import alternatives
from scalar.estimation.setup.refusal import misfit_refused
from scalar.geometry.se3 import log_so3
from tests.random_scene import make_scene

OF_PLANES = re.compile(r"\b(scans?|scanners?|planes?|labels?|mirrored)\b")


@pytest.fixture(scope="module")
def scene():
    """Return a scene before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7)


def test_a_target_that_sits_turned_is_no_mirrored_scan(scene):
    """A target whose frame is a quarter turn from nominal_pose is found by a tracker that measures orientations, and called a target."""
    dataset, truth = scene.dataset, scene.truth
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    R = truth.T_tracker_base[:3, :3] @ truth.sensor(dataset.q)[:, :3, :3] @ quarter
    turns = dict(zip(("rx", "ry", "rz"), log_so3(R).T, strict=True))
    (suspicion,) = calibrate(replace(dataset, point_columns=turns)).summary["setup"]
    assert suspicion["what"] == "sensor_pose"
    assert (
        "the target sits turned by 9" in suspicion["sentence"]
        and "mostly about its z" in suspicion["sentence"]
    )
    assert "rx,ry,rz" in suspicion["sentence"] and not OF_PLANES.search(suspicion["sentence"])


def test_no_refusal_of_tracked_poses_speaks_of_planes(scene):
    """Neither the alternatives that are tried on a tracker's data nor the refusal if none fits name planes, labels or scans."""
    dataset = scene.dataset
    texts = [f"{a.where} {a.says} {a.changed} {a.remedy}" for a in alternatives(dataset)]
    texts.append(str(misfit_refused(dataset, np.ones(dataset.n_poses))))
    for text in texts:
        assert not OF_PLANES.search(text), text


def test_a_file_that_is_named_exists():
    """Measurements are said to stand in the table of their kind; those of a probe are its joint angles."""
    files = {kind: format.measured_in for kind, format in sensor_formats().items()}
    assert files == {"line-laser": "scans.csv", "probe": "poses.csv", "tracker": "points.csv"}
