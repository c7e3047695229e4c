"""Candidate sets: columns are computed once for a state, and the candidates of a pool count wherever its parts stand."""

import numpy as np
import pytest

from scalar.diagnosis import candidate_columns, conditional_scores, unmodelled_structure
from scalar.diagnosis.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.conditional_scores import background_without, rivals
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


def test_a_candidate_and_its_rivals_are_corrected_for_the_same_number():
    """An effect of the state, scored among its rivals, has the score of the same candidate, also if further candidates are in other sets."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2),))
    for elsewhere in (0, 40):
        pool = CandidateSet.of([JointScale(2), JointScale(3)], elsewhere=elsewhere)
        own, others = rivals(state, 0, CandidateColumns.of(state, pool))
        same = next(score for score in others if score.effect.same_answer(own.effect))
        assert own.evidence == pytest.approx(same.evidence, abs=1e-6)
        assert own.p_value == pytest.approx(same.p_value, rel=1e-6)


def test_what_was_ranked_is_not_ranked_again(monkeypatch):
    """Rivals and flexible terms in an effect's place are the same when asked for again, without another ranking, and a caller may change its list."""
    dataset = make_scene(seed=3, poses_per_plane=15).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    state = refit(dataset, model, prepared.free, (JointScale(2),))
    pool = CandidateSet.of([JointScale(2), JointScale(3)])
    columns = CandidateColumns.of(state, pool)
    background = background_without(state, [0])[0]
    own, others = rivals(state, 0, columns)
    terms = unmodelled_structure._ranked_once(state, [background], [pool])
    for module in (conditional_scores, unmodelled_structure):
        monkeypatch.setattr(module, "rank", None)
    again = list(others)
    others.clear()
    assert rivals(state, 0, columns) == (own, again)
    assert unmodelled_structure._ranked_once(state, [background, background], [pool]) == 2 * terms
    assert background_without(state, [0])[0] is background
