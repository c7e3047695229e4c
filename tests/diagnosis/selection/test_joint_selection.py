"""Joint selection: several strong effects with few poses, which forward selection mistakes for a scatter of the poses."""

from types import SimpleNamespace

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState, refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.scoring.evidence_of_states import evidence_of
from scalar.diagnosis.selection.forward_selection import select_forward
from scalar.diagnosis.selection.joint_selection import _without_implausible, select_jointly
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, PoseData, make_cell, on_joint


def several(at: PoseData) -> np.ndarray:
    """Return errors of five joints' angles ``(N, n)`` [rad] that change predictions by about the same amount."""
    q, error = at.q, np.zeros_like(at.q)
    error[:, 0] = 1.2e-3 * np.sin(3 * q[:, 0] + 0.4)
    error[:, 1] = 1.0e-3 * np.sin(5 * q[:, 1] + 1.1)
    error[:, 2] = 1.0e-3 * np.sin(4 * q[:, 2] + 2.0)
    error[:, 3] = 2.0e-3 * q[:, 4]
    error[:, 4] = 3.0e-3 * q[:, 4]
    return error


TRUE = {
    ("joint_harmonic", 1),
    ("joint_harmonic", 2),
    ("joint_harmonic", 3),
    ("joint_coupling", 4),
    ("joint_scale", 5),
}


def selected(dataset) -> tuple[FittedState, FittedState]:
    """Return the state that forward selection finds, and the state after joint selection."""
    model, prepared = geometry_fit(dataset, effects_follow=True)
    before = refit(dataset, model, prepared.free, ())
    candidates = named_candidates(dataset)
    forward = select_forward(before, candidates)
    return forward, select_jointly(before, forward, candidates)


def named(state: FittedState) -> set[tuple[str, int]]:
    """Return the name and joint of every effect."""
    return {(effect.name, effect.target.get("joint")) for effect in state.effects}


@pytest.mark.parametrize("seed", [301, 302, 303])
def test_five_strong_effects_with_54_poses(seed):
    """All five effects are named and nothing else is, and the remaining scatter is no larger than the noise."""
    dataset = make_cell(Flaws(joints=several), seed=seed, poses_per_plane=18).dataset
    _, together = selected(dataset)
    assert named(together) == TRUE
    assert not together.variance_components


@pytest.mark.slow
def test_joints_that_do_not_repeat_stay_a_variance_component():
    """A scatter of the joints is not explained by effects, however many candidates there are."""
    wrong = 0
    for seed in range(311, 317):
        dataset = make_cell(Flaws(jitter=2e-4), seed=seed, poses_per_plane=18).dataset
        _, together = selected(dataset)
        wrong += bool(together.effects)
        assert any(c.name == "pose_jitter" for c in together.variance_components)
    assert wrong <= 1


def test_joint_selection_returns_the_state_with_more_evidence():
    """Of the state of forward selection and that of joint selection, the one that is returned has the larger evidence."""
    dataset = make_cell(Flaws(joints=several), seed=304, poses_per_plane=18).dataset
    forward, together = selected(dataset)
    candidates = named_candidates(dataset)
    assert evidence_of(together, candidates) >= evidence_of(forward, candidates)


def test_each_order_of_a_joint_counts_as_chosen():
    """With a hundred times as many candidates, the evidence of a harmonic of three orders falls by three times the logarithm of a hundred, and that
    of a scale error by once that.
    """
    dataset = make_cell(seed=305, poses_per_plane=10, points_per_scan=20).dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    few, many = SimpleNamespace(total=10), SimpleNamespace(total=1000)
    for effect, parts in ((JointHarmonic(2, (3, 5, 8)), 3), (JointScale(2), 1)):
        state = refit(dataset, model, prepared.free, (effect,))
        lost = evidence_of(state, few) - evidence_of(state, many)  # type: ignore[arg-type]
        assert lost == pytest.approx(parts * np.log(100.0), rel=1e-9)


def test_one_impossible_effect_is_no_reason_to_refuse_the_others(monkeypatch):
    """Of a set with a scale error and a harmonic that cannot be, the scale error is kept, whatever the evidence of the harmonic."""
    dataset = make_cell(
        Flaws(joints=on_joint(3, lambda at: 1e-3 * at.q[:, 2])), seed=5, poses_per_plane=15
    ).dataset
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, [JointScale(3), JointHarmonic(5, (7,))])
    candidates = named_candidates(dataset)
    assert _without_implausible(state, candidates) is state
    monkeypatch.setattr(JointHarmonic, "is_impossible", lambda *_: True)
    assert not state.is_plausible
    assert [effect.name for effect in _without_implausible(state, candidates).effects] == ["joint_scale"]
