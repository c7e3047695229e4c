"""Thresholds of the selection of effects: each is tested with numbers on both sides of it, so that half or double the threshold changes the decision.

``snakemake sensitivity`` names these tests for thresholds on which no blind set depends.
"""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import blocks
from scalar.diagnosis.scoring import ranking
from scalar.diagnosis.scoring.ranking import Scored
from scalar.diagnosis.selection import backward_elimination, forward_selection, joint_selection, subset_search
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import Tried, scored, state


def test_an_effect_is_worth_a_fit_only_beyond_chance(monkeypatch):
    """A candidate with a p-value of seven in ten thousand is significant, and one with fifteen in ten thousand is not."""
    entries = [scored(JointScale(joint), p_value=p) for joint, p in ((1, 7e-4), (2, 15e-4))]
    monkeypatch.setattr(forward_selection, "rank", lambda *_: entries)
    monkeypatch.setattr(forward_selection, "refined", lambda state, background, entry: entry)
    found = forward_selection._significant_candidates(state(background=lambda: None), None)  # type: ignore[arg-type]
    assert [entry.effect.joint for entry in found] == [1]  # type: ignore[attr-defined]


@pytest.mark.parametrize(("confirmed", "taken"), [(6, True), (12, False)])
def test_few_candidates_are_tried_at_a_step(confirmed, taken, monkeypatch):
    """If held-out poses confirm the sixth candidate by evidence alone, it is taken; the twelfth is not tried any more."""
    entries = [scored(JointHarmonic(1, (order,)), 100.0 - order) for order in range(1, 16)]
    wanted = entries[confirmed - 1].effect
    monkeypatch.setattr(forward_selection, "rank", lambda state, background, columns, count: entries[:count])
    monkeypatch.setattr(forward_selection, "refined", lambda state, background, entry: entry)
    monkeypatch.setattr(forward_selection, "_has_enough_evidence", lambda *_: True)
    monkeypatch.setattr(forward_selection, "merged", lambda effects, effect: effect)
    monkeypatch.setattr(forward_selection, "held_out_errors", lambda state, whitening=None: state)
    monkeypatch.setattr(forward_selection, "no_worse", lambda *_: True)
    monkeypatch.setattr(
        forward_selection, "improvement", lambda before, after: 100.0 if after.effects is wanted else 0.0
    )

    def fitted(effects: Any) -> Any:
        """Return a stand-in for a fitted state."""
        return SimpleNamespace(
            effects=effects,
            settings=DEFAULTS,
            whitening=None,
            is_plausible=True,
            refitted=fitted,
            background=lambda: None,
        )

    found = forward_selection._with_best_candidate(fitted(()), None, set())  # type: ignore[arg-type]
    assert (found is not None) == taken


def test_another_effect_takes_a_place_only_with_clearly_more_evidence():
    """A rival with four nats more evidence is fitted in an effect's place, and one with two nats more is not."""
    own, other = scored(JointScale(2)), JointHarmonic(4, (7,))
    with pytest.raises(Tried):
        forward_selection._replaced(state(), (), own, [scored(other, 104.0), own])
    assert forward_selection._replaced(state(), (), own, [scored(other, 102.0), own]) is None


@pytest.mark.parametrize(("evidence", "enough"), [(5.0, False), (10.0, True)])
def test_a_second_effect_of_one_load_needs_more_evidence(evidence, enough, monkeypatch):
    """With ten nats, a compliance of the base stays beside one of joint 2; with five, it is left out. Without another effect of the load, five
    suffice. The stronger of the two is never left out for the other.
    """
    joint, base = JointCompliance(((2, 3),)), BaseCompliance((3,))
    scores = {joint: scored(joint, 20.0), base: scored(base, evidence)}
    own_alone = lambda state, i, *_: (scores[state.effects[i]], [scores[state.effects[i]]])  # noqa: E731
    monkeypatch.setattr(forward_selection, "rivals", own_alone)
    monkeypatch.setattr(forward_selection, "rivals_of_strongest_part", lambda *_: [])
    monkeypatch.setattr(forward_selection, "score_together", lambda state, indices, *_: scores[state.effects[indices[0]]])  # fmt: skip
    monkeypatch.setattr(forward_selection, "background_without", lambda *_: None)
    columns = SimpleNamespace(candidates=None)
    monkeypatch.setattr(forward_selection, "CandidateColumns", SimpleNamespace(of=lambda *_: columns))

    def with_effects(*effects: Any) -> Any:
        """Return a stand-in for a state with some effects; its refit has others."""
        return SimpleNamespace(settings=DEFAULTS, effects=effects, refitted=lambda new: with_effects(*new))

    for effects in ((joint, base), (base, joint)):
        kept = forward_selection.reconsidered(with_effects(*effects), None)[0].effects  # type: ignore[arg-type]
        assert kept == (effects if enough else (joint,))
    assert forward_selection.reconsidered(with_effects(base), None)[0].effects == (base,)  # type: ignore[arg-type]


@pytest.mark.parametrize(("behind", "takes_its_place"), [(5.0, True), (10.0, False)])
def test_a_further_joint_of_one_load_takes_the_place_of_a_second_effect(behind, takes_its_place):
    """A further joint of a compliance replaces a compliance of the base if it explains five nats less, and not if it explains ten less."""
    base, others, further = BaseCompliance((3,)), (JointCompliance(((3, 3),)),), JointCompliance(((2, 3),))
    ranking = [scored(base, 100.0), scored(further, 100.0 - behind)]
    with pytest.raises(Tried) if takes_its_place else nullcontext():
        assert forward_selection._replaced(state(), others, ranking[0], ranking) is None


@pytest.mark.parametrize(("more", "enough"), [(40.0, False), (70.0, True)])
def test_held_out_poses_need_not_confirm_what_is_overwhelming(more, enough, monkeypatch):
    """A set that improves held-out errors by one standard error is taken with seventy nats more evidence, and not with forty. In the same way, a part
    of a set that costs seventy nats stays although held-out errors do not rise clearly without it.
    """
    for module in (joint_selection, backward_elimination):
        monkeypatch.setattr(module, "evidence_of", lambda state, _: state.nats)
        monkeypatch.setattr(module, "held_out_errors", lambda *_: None)
        monkeypatch.setattr(module, "improvement", lambda *_: 1.0)
    monkeypatch.setattr(joint_selection, "no_worse", lambda *_: True)
    monkeypatch.setattr(joint_selection, "improves_with_limited_blocks", lambda *_: False)
    monkeypatch.setattr(
        backward_elimination, "held_out_errors_without", lambda _, left_out, __: [None] * len(left_out)
    )
    smaller = state(nats=100.0, is_plausible=True, whitening=None, effects=())
    larger = state(nats=100.0 + more, is_plausible=True, whitening=None, effects=(JointScale(2),))
    larger.refitted = lambda *_: smaller
    assert (joint_selection.clearly_better(smaller, larger, None) is larger) == enough  # type: ignore[arg-type]
    assert (backward_elimination.eliminate_backward(larger, None) is larger) == enough  # type: ignore[arg-type]


@pytest.mark.parametrize(("gained", "goes_on"), [(0.035, False), (0.07, True)])
def test_a_refinement_has_to_gain(gained, goes_on, monkeypatch):
    """A refinement that gains 0.07 nats is kept, and one that gains 0.035 is not."""
    background: Any = SimpleNamespace(sum_of_squares=200.0, degrees_of_freedom=100)
    entry = scored(JointHarmonic(4, (7,)))
    left = (background.sum_of_squares - entry.gain) * np.exp(-2 * gained / background.degrees_of_freedom)
    better = replace(entry, gain=background.sum_of_squares - left)
    monkeypatch.setattr(ranking, "rank", lambda *_: [better])
    monkeypatch.setattr(ranking, "CandidateColumns", lambda *_: None)
    monkeypatch.setattr(ranking.CandidateSet, "of", lambda _: SimpleNamespace(tried=[1, 2]))
    monkeypatch.setattr(JointHarmonic, "at_a_pose", lambda self, *_: self)
    found = ranking._best_variation(
        state(dataset=None, residuals=SimpleNamespace(poses=None)), background, entry, 1.0
    )
    assert (found is not entry) == goes_on


def test_refinement_ends_even_if_it_always_gains(monkeypatch):
    """A refinement that always gains is made three times with steps of each of three sizes."""
    looks: list[float] = []

    def always_better(state: Any, background: Any, entry: Scored, scale: float) -> Scored:
        looks.append(scale)
        return replace(entry, evidence=entry.evidence + 1.0)

    monkeypatch.setattr(ranking, "_best_variation", always_better)
    ranking.refined(state(), None, scored(JointHarmonic(4, (7,))))  # type: ignore[arg-type]
    assert looks == [1.0] * 3 + [0.5] * 3 + [0.25] * 3


@pytest.mark.parametrize(("n_poses", "few"), [(350, True), (700, False)])
def test_effects_are_selected_together_where_poses_are_few(n_poses, few, monkeypatch):
    """Sets of effects are searched with 350 poses, and not with 700."""
    asked = []
    monkeypatch.setattr(joint_selection, "best_subset", lambda *_: asked.append(True))
    monkeypatch.setattr(joint_selection, "eliminate_backward", lambda given, *_: given)
    before = state(dataset=SimpleNamespace(n_poses=n_poses), is_rounding=False)
    joint_selection.select_jointly(before, state(), None)  # type: ignore[arg-type]
    assert bool(asked) == few


def test_what_is_proposed_is_stable(monkeypatch):
    """Of a set of two elements, one is needed without each of three fifths of the folds, and the other without each of two fifths: only the first is
    proposed.
    """
    q = np.arange(60.0)[:, None]
    fold = blocks(q, DEFAULTS.hold_out)[1]
    monkeypatch.setattr(subset_search, "blocks_of", lambda _: (fold, fold))
    needed = {0: {0, 1, 2}, 1: {0, 1}}

    def elements(poses: Any) -> Any:
        missing = set(range(5)) - set(fold[poses].tolist())

        def evidence(some: tuple[int, ...]) -> float:
            left_out = {0, 1} - set(some)
            return -sum(1.0 if missing <= needed[p] else -1.0 for p in left_out)

        return SimpleNamespace(
            best=lambda: (0, 1),
            subsets=lambda sets: [SimpleNamespace(evidence=evidence(some)) for some in sets],
        )

    found = SimpleNamespace(onsets=[(), ()], effects=[JointScale(1), JointScale(2)], of_poses=elements)
    found.of_all_poses = lambda: elements(np.arange(60))
    found.only = lambda chosen: found
    monkeypatch.setattr(
        subset_search._Rows, "of", lambda *_: SimpleNamespace(element_rows=lambda moments: found)
    )
    given = state(dataset=SimpleNamespace(n_poses=60, q=q))
    assert [effect.joint for effect in subset_search.best_subset(given, None)] == [1]  # type: ignore[attr-defined, arg-type]


def with_effect(effect):
    """Return a stand-in for a fitted state with one effect."""
    nowhere = SimpleNamespace(robot=None, poses=None)
    return state(effects=(effect,), dataset=nowhere, residuals=nowhere)


@pytest.mark.parametrize(("sizes", "plausible"), [(7.0, True), (14.0, False)])
def test_a_coefficient_far_beyond_its_prior_is_implausible(sizes, plausible):
    """A coefficient of seven prior standard deviations is plausible, and one of fourteen is not."""
    effect = JointScale(1)
    given = with_effect(effect.with_coefficients(sizes * effect.prior_std))
    assert (not FittedState.implausible_effects.fget(given)) == plausible  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("effect", "limit"), [(JointCompliance(((3, 3),)), 1e-2), (BaseCompliance((3,)), 5e-3)]
)
def test_no_arm_gives_way_by_a_degree(effect, limit):
    """A deflection of a joint by 10 mrad under the arm's weight is plausible, and a larger one is not; of the base, half as much."""
    coefficients = np.zeros(len(effect.coefficients))
    for share, plausible in ((0.9, True), (1.1, False)):
        coefficients[0] = share * limit
        given = with_effect(effect.with_coefficients(coefficients))
        assert (not FittedState.implausible_effects.fget(given)) == plausible  # type: ignore[attr-defined]


def test_an_order_with_a_prior_of_its_own_is_plausible_up_to_the_size_in_real_gears():
    """The prior of an order is scaled for rows whose weights are too large; an order of 1 mrad stays plausible, and one of 40 mrad does not."""
    effect = JointHarmonic(1, (1,)).with_term_std([1e-6])
    for size, plausible in ((1e-3, True), (4e-2, False)):
        given = with_effect(effect.with_coefficients([size, 0.0]))
        assert (not FittedState.implausible_effects.fget(given)) == plausible  # type: ignore[attr-defined]


@pytest.mark.parametrize(("more", "enough"), [(40.0, False), (70.0, True)])
def test_one_block_does_not_decide_against_what_is_overwhelming(more, enough, monkeypatch):
    """Held-out errors grow by one standard error, but most blocks gain: a set is taken with seventy nats more evidence, and not with forty."""
    monkeypatch.setattr(joint_selection, "evidence_of", lambda state, _: state.nats)
    monkeypatch.setattr(joint_selection, "held_out_errors", lambda *_: None)
    monkeypatch.setattr(joint_selection, "improvement", lambda *_: -1.0)
    monkeypatch.setattr(joint_selection, "no_worse", lambda *_: False)
    monkeypatch.setattr(joint_selection, "improves_with_limited_blocks", lambda *_: True)
    smaller = state(nats=100.0, is_plausible=True, whitening=None, effects=())
    larger = state(nats=100.0 + more, is_plausible=True, whitening=None, effects=(JointScale(2),))
    assert (joint_selection.clearly_better(smaller, larger, None) is larger) == enough  # type: ignore[arg-type]
