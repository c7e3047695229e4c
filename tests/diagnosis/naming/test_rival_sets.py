"""An effect is compared with sets of other effects: a true cause leads them clearly, and what only resembles two causes does not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.naming import judged_effects
from scalar.diagnosis.naming.rival_sets import CLEAR_ODDS, RivalSet, _standard_error, nearest_set
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, named_candidates
from scalar.diagnosis.scoring.conditional_scores import rivals
from scalar.diagnosis.scoring.ranking import rank
from scalar.effects import Effect
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.diagnosis.stand_ins import finding_of
from tests.effects.injected import Flaws, PoseData, make_cell

GEAR = JointHarmonic(2, (2,))


def second_order(at: PoseData) -> np.ndarray:
    """Return a gear error of the second order of joint 2."""
    error = np.zeros_like(at.q)
    error[:, 1] = 6e-4 * np.sin(2 * at.q[:, 1] + 0.3)
    return error


def two_gears(at: PoseData) -> np.ndarray:
    """Return an error of joint 2 of the first order of its own gear and of the second order of the angle of joint 3."""
    error = np.zeros_like(at.q)
    error[:, 1] = 6e-4 * np.sin(at.q[:, 1] + 0.3) + 4e-4 * np.sin(2 * at.q[:, 2] + 1.0)
    return error


def state_with(effect: Effect, joints: Any) -> FittedState:
    """Return a workcell of 60 poses fitted with one effect."""
    dataset = make_cell(Flaws(joints=joints), seed=91, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    return refit(dataset, model, prepared.free, [effect])


def test_a_true_cause_leads_every_set():
    """A gear error that is there leads the nearest set of other effects by many standard errors."""
    state = state_with(GEAR, second_order)
    nearest = nearest_set(state, 0, CandidateColumns.of(state, named_candidates(state.dataset)))
    assert nearest is not None and nearest.lead > 3 * nearest.std
    assert nearest.probability > 0.99
    assert not any(effect.same_answer(GEAR) for effect in nearest.effects)


def test_two_effects_together_come_nearer_than_each_alone():
    """A compliance of joint 2 explains two errors at once and leads every single rival; the two that were injected explain as much."""
    dataset = make_cell(Flaws(joints=two_gears), seed=91, poses_per_plane=30).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    before = refit(dataset, model, prepared.free, [])
    candidates = named_candidates(dataset)
    best = rank(before, before.background(), CandidateColumns.of(before, candidates), 1)[0].effect
    assert (best.name, best.target) == ("joint_compliance", {"joints": [2]})
    state = before.refitted([best])
    own, ranking = rivals(state, 0, CandidateColumns.of(state, candidates))
    single = max(s.evidence for s in ranking if not s.effect.same_answer(best))
    assert own.evidence > single + 5.0  # no single rival is confounded with it
    nearest = nearest_set(state, 0, CandidateColumns.of(state, candidates))
    assert nearest is not None and nearest.lead < 2.0 and nearest.probability < 0.8
    orders = [(effect.target["joint"], effect.target["order"]) for effect in nearest.effects]
    assert orders == [(2, 1), (3, 2)]


def test_repetitions_of_a_pose_count_as_one():
    """If every pose is measured twice, the standard error of the sum doubles; with as many independent poses it would grow by the root of two."""
    once = make_cell(seed=91, poses_per_plane=20).dataset
    model, prepared = geometry_fit(once, effects_follow=True)
    state = refit(once, model, prepared.free, [])
    rng = np.random.default_rng(4)
    own, other = rng.normal(size=(2, once.n_poses, 3))
    single = _standard_error(state, background(own), background(other))
    scatter = np.sum(other**2 - own**2, axis=1) / 2
    assert single == pytest.approx(np.std(scatter, ddof=1) * np.sqrt(len(scatter)))
    twice = SimpleNamespace(
        dataset=SimpleNamespace(q=np.repeat(once.q, 2, axis=0)),
        rows=state.rows, residuals=state.residuals, model=state.model, settings=state.settings,
    )  # fmt: skip
    rows = (background(np.repeat(residual, 2, axis=0)) for residual in (own, other))
    assert _standard_error(twice, *rows) == pytest.approx(2 * single)  # type: ignore[arg-type]


def background(residual: np.ndarray) -> Any:
    """Return a stand-in for a background with the residual of every pose and the variance 1."""
    return SimpleNamespace(residual=residual, variance=1.0)


@pytest.mark.parametrize(
    ("lead", "confidence", "doubtful", "listed"),
    [(30.0, 0.95, False, 0), (4.0, 0.8188, False, 1), (0.4, 0.5363, True, 1)],
)
def test_a_name_is_no_surer_than_its_lead_over_the_nearest_set(
    monkeypatch, lead, confidence, doubtful, listed
):
    """The confidence is at most the probability of the lead; what explains about as much is listed as confounded, and a slight lead gives no name."""
    found = judged(monkeypatch, RivalSet((JointScale(2), JointHarmonic(2, (8,))), lead, 4.0))
    assert found.confidence == pytest.approx(confidence, abs=1e-4)
    assert found.doubtful is doubtful
    assert [effect.name for effect in found.confounded_with] == ["joint_scale"] * listed


def test_sets_are_not_looked_for_where_every_rival_is_far_behind(monkeypatch):
    """A name whose odds against single rivals are clear keeps its confidence."""
    tie = RivalSet((JointScale(2),), 0.0, 4.0)
    assert judged(monkeypatch, tie, CLEAR_ODDS + 1.0).confidence == 0.95
    assert judged(monkeypatch, tie, CLEAR_ODDS - 1.0).confidence == 0.5


def judged(monkeypatch: pytest.MonkeyPatch, nearest: RivalSet, log_odds: float = 8.0) -> Any:
    """Return a finding with a confidence of 0.95 after the comparison with a set."""
    state = state_with(GEAR, second_order)
    monkeypatch.setattr(judged_effects, "nearest_set", lambda *_: nearest)
    found = finding_of(GEAR, 0.95)
    object.__setattr__(found, "grounds", SimpleNamespace(log_odds=log_odds))
    columns = CandidateColumns.of(state, named_candidates(state.dataset))
    return judged_effects._compared_with_sets(found, state, 0, columns)
