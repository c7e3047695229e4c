"""Poses that contradict their own session, at its boundary, and fit the next one show that the boundary is stated too late or too early."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.sessions.session_boundary import misplaced_boundaries
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.geometry.se3 import exp_so3
from tests.random_scene import make_scene

MOVED_AT = 40  # row from which on the tracker stands elsewhere


@pytest.fixture(scope="module")
def moved():
    """Return seventy-five poses before a tracker that was set up anew some centimetres away, without a column ``session``."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    points = dataset.points.copy()
    points[MOVED_AT:] = points[MOVED_AT:] @ exp_so3([0.0, 0.02, -0.02]).T + [0.03, 0.0, 0.02]
    return replace(dataset, points=points)


@pytest.fixture(scope="module")
def model(moved):
    """Return the model of a calibration whose sessions change where the tracker moved."""
    return calibrate(changing_at(moved, MOVED_AT)).model


def changing_at(dataset, row):
    """Return the dataset with the column ``session`` changing at a row."""
    session = np.where(np.arange(dataset.n_poses) < row, "one", "two")
    return replace(dataset, poses=dataset.poses.assign(session=session))


@pytest.mark.parametrize(("row", "word"), [(MOVED_AT + 10, "too late"), (MOVED_AT - 10, "too early")])
def test_a_boundary_that_is_stated_elsewhere_is_said(moved, model, row, word):
    """The sentence names the poses between, the stated boundary and the pose at which the tracker moved."""
    stated, ids = changing_at(moved, row), moved.pose_ids
    low, high = sorted((row, MOVED_AT))
    (suspicion,) = misplaced_boundaries(stated, set(ids[low:high].tolist()), model)
    assert f"poses {ids[low]} to {ids[high - 1]} are set aside" in suspicion.sentence
    assert f"{word}, at pose {ids[row]}" in suspicion.sentence
    assert f"change at pose {ids[MOVED_AT]}" in suspicion.sentence
    assert suspicion.rms_after < 1e-3 < suspicion.rms_before


def test_gross_errors_at_a_boundary_are_no_boundary(moved, model):
    """Poses before the boundary that fit neither session say nothing of it; nor do two poses alone, nor poses elsewhere."""
    ids = moved.pose_ids
    points = moved.points.copy()
    points[MOVED_AT - 5 : MOVED_AT] += 0.05 * np.random.default_rng(3).normal(size=(5, 3))
    wrong = changing_at(replace(moved, points=points), MOVED_AT)
    assert misplaced_boundaries(wrong, set(ids[MOVED_AT - 5 : MOVED_AT].tolist()), model) == []
    late = changing_at(moved, MOVED_AT + 2)
    assert misplaced_boundaries(late, set(ids[MOVED_AT : MOVED_AT + 2].tolist()), model) == []
    assert misplaced_boundaries(changing_at(moved, MOVED_AT), set(ids[:5].tolist()), model) == []
    assert misplaced_boundaries(moved, set(ids[:5].tolist()), model) == []


@pytest.mark.slow
def test_a_diagnosis_says_that_a_boundary_is_late(moved):
    """All three calibrations of the diagnosis have the sentence."""
    diagnosis = diagnose(changing_at(moved, MOVED_AT + 8))
    for calibration in (diagnosis.calibration_before, diagnosis.calibration_after):
        assert ["too late" in entry["sentence"] for entry in calibration.summary["setup"]] == [True]
    assert len(diagnosis.cleaned.outlier_poses) == 8


@pytest.mark.slow
def test_a_calibration_names_the_boundary_that_comes_too_late(moved):
    """Where a session exists, its boundary is to be corrected, and no further column is asked for."""
    with pytest.raises(WrongSetup) as refused:
        calibrate(changing_at(moved, MOVED_AT + 12))
    (suspicion,) = refused.value.suspicions
    ids = moved.pose_ids
    assert f"column session in poses.csv change at pose {ids[MOVED_AT]}; it changes" in suspicion.sentence
    assert f"at pose {ids[MOVED_AT + 12]}, which is too late" in suspicion.sentence
