"""The columns of a candidate set are computed once for a fitted state, and never taken for those of another state or set."""

import numpy as np

from scalar.diagnosis import candidate_columns
from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.fitted_state import refit
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.random_scene import make_scene


def test_columns_are_kept_for_their_state_and_set(monkeypatch):
    """The same state and set return the same object, and any other state or set another one; beyond the limit of memory nothing is kept."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, ())
    pool, other_pool = (CandidateSet.of([JointScale(joint)]) for joint in (2, 3))
    kept = CandidateColumns.of(state, pool)
    assert CandidateColumns.of(state, pool) is kept
    other_state = state.refitted([JointScale(4)])
    for columns in (CandidateColumns.of(state, other_pool), CandidateColumns.of(other_state, pool)):
        assert columns is not kept
        assert not np.array_equal(columns.E, kept.E)
    monkeypatch.setattr(candidate_columns, "_MOST_KEPT", 0)
    third = state.refitted([JointScale(5)])
    assert CandidateColumns.of(third, pool) is not CandidateColumns.of(third, pool)
