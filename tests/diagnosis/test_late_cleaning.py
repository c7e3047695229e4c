"""Poses that are set aside given the effects: everything that is reported afterwards is computed from the poses that remain."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.diagnosis.settings import Settings
from scalar.estimation.settings import changed
from tests.diagnosis.cases import scale

MODULE = sys.modules["scalar.diagnosis.cleaning"]


def removing_one_pose(calls):
    """Return a cleaning that sets aside the first of the remaining poses whenever it is called, and adds its id to ``calls``."""

    def clean_given_effects(cleaned, distance, brief, settings):
        dataset = cleaned.dataset
        assert len(distance) == dataset.n_poses
        calls.append(int(dataset.pose_ids[0]))
        rest = dataset.subset(np.arange(dataset.n_poses) > 0)
        return replace(cleaned, dataset=rest, outlier_poses=(*cleaned.outlier_poses, calls[-1]))

    return clean_given_effects


@pytest.mark.parametrize("rounds", [1, 3])
def test_what_is_reported_is_of_the_poses_that_remain(rounds, monkeypatch):
    """If every cleaning still sets a pose aside, states, calibrations, errors and report are of the same poses."""
    dataset = scale(5, poses_per_plane=20)[0].dataset
    calls = []
    monkeypatch.setattr(MODULE, "clean_given_effects", removing_one_pose(calls))
    diagnosis = diagnose(dataset, settings=changed(Settings(), {"selection.max_cleanings": rounds}))
    assert len(calls) == rounds
    remain = dataset.n_poses - rounds
    mapping = diagnosis.to_mapping()
    assert mapping["outliers"]["poses"] == sorted(calls)
    assert diagnosis.cleaned.dataset.n_poses == remain
    for state in (diagnosis.before, diagnosis.after):
        np.testing.assert_array_equal(state.dataset.pose_ids, diagnosis.cleaned.dataset.pose_ids)
    for calibration in (diagnosis.calibration_before, diagnosis.calibration_after):
        assert calibration.summary["poses"] == remain
    assert len(diagnosis.held_out_before.metric) == len(diagnosis.shipped.held_out.metric) == remain
    # The root mean square residual of either calibration is that of its own state.
    train = mapping["residual"]["after"]["train_rms_mm"]
    assert train == pytest.approx(1e3 * diagnosis.calibration_after.residual_rms, rel=1e-4)
