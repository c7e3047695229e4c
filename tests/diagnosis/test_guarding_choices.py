"""Thresholds of what the diagnosis chooses, on numbers made to fall between one and the other: halved or doubled, each chooses otherwise.

``snakemake sensitivity`` names these tests for thresholds that no blind set puts to the test.
"""

import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import (
    focused_choice,
    forward_selection,
    joint_selection,
    ranking,
    shipped_fit,
    subset_search,
    unmodelled_structure,
)
from scalar.diagnosis.explained import Explained
from scalar.diagnosis.finding import Finding
from scalar.diagnosis.fitted_state import FittedState, refit
from scalar.diagnosis.identified_components import identified_components
from scalar.diagnosis.ranking import Scored
from scalar.diagnosis.result import Diagnosis
from scalar.diagnosis.settings import DEFAULTS
from scalar.diagnosis.variance_components import VarianceComponent
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import make_cell

components = sys.modules["scalar.diagnosis.identified_components"]
NOISES = (("best", 30.0), ("near", 28.0), ("far", 26.0))  # with the log likelihood that each gains
DIAGNOSE = sys.modules["scalar.diagnosis.diagnose"]  # the package's own name for it is the function


def scored(effect: Any, evidence: float = 100.0, p_value: float = 1e-9, dof: int = 1) -> Scored:
    """Return an effect with a score."""
    return Scored(effect, 1.0, dof, evidence, p_value, 1.0)


class Tried(Exception):
    """An alternative was good enough to be fitted."""


def tried(*_: Any) -> Any:
    """Stand for a refit."""
    raise Tried


def state(**more: Any) -> Any:
    """Return what stands for a fitted state: its settings, and a refit that says that it was asked for."""
    return SimpleNamespace(settings=DEFAULTS, refitted=tried, **more)


def test_an_effect_is_worth_a_fit_only_beyond_chance(monkeypatch):
    """Chances of seven and of fifteen in ten thousand: one in a thousand lies between them."""
    entries = [scored(JointScale(joint), p_value=p) for joint, p in ((1, 7e-4), (2, 15e-4))]
    monkeypatch.setattr(forward_selection, "rank", lambda *_: entries)
    monkeypatch.setattr(forward_selection, "refined", lambda state, background, entry: entry)
    found = forward_selection._best(state(background=lambda: None), None)  # type: ignore[arg-type]
    assert [entry.effect.joint for entry in found] == [1]  # type: ignore[attr-defined]


def test_another_effect_takes_a_place_only_with_clearly_more_evidence():
    """Four nats more are enough for a trial, two are not."""
    own, other = scored(JointScale(2)), JointHarmonic(4, (7,))
    with pytest.raises(Tried):
        forward_selection._replaced(state(), (), own, [scored(other, 104.0), own])
    assert forward_selection._replaced(state(), (), own, [scored(other, 102.0), own]) is None


@pytest.mark.parametrize(("gained", "goes_on"), [(0.035, False), (0.07, True)])
def test_a_finer_look_has_to_gain(gained, goes_on, monkeypatch):
    """A gain of 0.07 nats is worth another look, one of 0.035 is not."""
    background: Any = SimpleNamespace(squared=200.0, freedom=100)
    entry = scored(JointHarmonic(4, (7,)))
    left = (background.squared - entry.gain) * np.exp(-2 * gained / background.freedom)
    better = replace(entry, gain=background.squared - left)
    monkeypatch.setattr(ranking, "rank", lambda *_: [better])
    monkeypatch.setattr(ranking, "CandidateColumns", lambda *_: None)
    monkeypatch.setattr(ranking.CandidateSet, "of", lambda _: SimpleNamespace(tried=[1, 2]))
    monkeypatch.setattr(JointHarmonic, "at_a_pose", lambda self, *_: self)
    found = ranking._look(state(dataset=None, residuals=SimpleNamespace(poses=None)), background, entry, 1.0)
    assert (found is not entry) == goes_on


def test_a_look_that_always_gains_is_not_repeated_for_ever(monkeypatch):
    """Three times with steps of each of three sizes."""
    looks: list[float] = []

    def always_better(state: Any, background: Any, entry: Scored, scale: float) -> Scored:
        looks.append(scale)
        return replace(entry, evidence=entry.evidence + 1.0)

    monkeypatch.setattr(ranking, "_look", always_better)
    ranking.refined(state(), None, scored(JointHarmonic(4, (7,))))  # type: ignore[arg-type]
    assert looks == [1.0] * 3 + [0.5] * 3 + [0.25] * 3


@pytest.mark.parametrize(("n_poses", "few"), [(350, True), (700, False)])
def test_effects_are_selected_together_where_poses_are_few(n_poses, few, monkeypatch):
    """350 poses are few, 700 are not."""
    asked = []
    monkeypatch.setattr(joint_selection, "best_subset", lambda *_: asked.append(True))
    monkeypatch.setattr(joint_selection, "borne_out", lambda given: given)
    before = state(dataset=SimpleNamespace(n_poses=n_poses), is_rounding=False)
    joint_selection.select_together(before, state(), None)  # type: ignore[arg-type]
    assert bool(asked) == few


def test_what_is_proposed_is_stable(monkeypatch):
    """Of a set of two, one is needed without each of three fifths of the poses, the other of two fifths: the former is proposed."""
    q = np.arange(60.0)[:, None]
    fold = subset_search.blocks(q, DEFAULTS.hold_out)[1]
    needed = {0: {0, 1, 2}, 1: {0, 1}}

    def pieces(poses: Any) -> Any:
        missing = set(range(5)) - set(fold[poses].tolist())

        def evidence(some: tuple[int, ...]) -> float:
            left_out = {0, 1} - set(some)
            return -sum(1.0 if missing <= needed[p] else -1.0 for p in left_out)

        return SimpleNamespace(
            best=lambda: (0, 1),
            subsets=lambda sets: [SimpleNamespace(evidence=evidence(some)) for some in sets],
        )

    laid = SimpleNamespace(begins=[(), ()], effects=[JointScale(1), JointScale(2)], pieces=pieces)
    laid.only = lambda chosen: laid
    monkeypatch.setattr(subset_search._Rows, "of", lambda *_: SimpleNamespace(laid_out=lambda moments: laid))
    given = state(dataset=SimpleNamespace(n_poses=60, q=q))
    assert [effect.joint for effect in subset_search.best_subset(given, None)] == [1]  # type: ignore[attr-defined, arg-type]


@pytest.mark.parametrize(("sizes", "plausible"), [(7.0, True), (14.0, False)])
def test_a_coefficient_far_beyond_its_prior_is_implausible(sizes, plausible):
    """Seven times the standard deviation of its prior, and fourteen times."""
    effect = JointScale(1)
    given = state(effects=(effect.with_coefficients(sizes * effect.prior_std),))
    assert FittedState.is_plausible.fget(given) == plausible  # type: ignore[attr-defined]


@pytest.mark.parametrize(("chance", "is_tried"), [(7e-6, True), (15e-6, False)])
def test_structure_without_a_name_has_to_be_far_beyond_chance(chance, is_tried, monkeypatch):
    """Seven in a million are too little for chance, fifteen in a million are not."""
    entry = scored(JointHarmonic(4, (7,)), p_value=chance)
    monkeypatch.setattr(unmodelled_structure, "_ranked", lambda *_: [[entry]])
    monkeypatch.setattr(unmodelled_structure, "refined", lambda state, background, entry: entry)
    given = state(background=lambda: None, effects=())
    if is_tried:
        with pytest.raises(Tried):
            unmodelled_structure._with_best(given, [])
    else:
        assert unmodelled_structure._with_best(given, []) is None


def replacing(monkeypatch: Any, evidence: float, dof: int) -> list[str]:
    """Return what was done to replace a named effect: ``refitted`` and ``several``.

    Args:
        monkeypatch: Of the test.
        evidence: Of a flexible term in the place of the effect, whose own is 100.
        dof: Of the effect; the term has as many, so that it is compared with all of the effect's evidence.
    """
    done: list[str] = []
    named = JointHarmonic(4, (7,))
    given: Any = SimpleNamespace(effects=(named,), dataset=None, settings=DEFAULTS, whitening=None)
    given.refitted = lambda effects: done.append("refitted")
    stand_ins: dict[str, Any] = {
        "background_without": lambda *_: (None, None, None),
        "together": lambda *_: scored(named, 100.0, dof=dof),
        "_ranked": lambda *_: [[scored(JointScale(4), evidence, dof=dof)]],
        "_imitating": lambda *_: [],
        "refined": lambda state, background, entry: entry,
        "_with_partial_imitators": lambda *_: done.append("several") or (None, 0.0),
        "held_out_errors": lambda *_: None,
        "improvement": lambda *_: 0.0,
        "no_worse": lambda *_: True,
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(unmodelled_structure, name, stand_in)
    monkeypatch.setattr(JointHarmonic, "imitators", lambda *_: [JointScale(4)])
    unmodelled_structure._with_replacement(given, [None])  # type: ignore[list-item]
    return done


def test_a_term_that_explains_far_less_than_a_name_is_not_refined(monkeypatch):
    """With 60 % of the name's evidence it is not, with 80 % it is."""
    assert not replacing(monkeypatch, 60.0, dof=2)
    assert "refitted" in replacing(monkeypatch, 80.0, dof=2)


def test_several_shapes_are_not_tried_in_the_place_of_a_spectrum(monkeypatch):
    """In the place of six orders they are, in that of twelve they are not."""
    assert "several" in replacing(monkeypatch, 80.0, dof=12)
    assert "several" not in replacing(monkeypatch, 80.0, dof=24)


def test_a_name_that_explains_little_beside_structure_without_one_is_dropped(monkeypatch):
    """Of the structure that a flexible term explains, 7 % and 15 %: the former is as likely a part of that structure."""
    kinds = [
        SimpleNamespace(flexible=f, is_change_in_time=False, depends_on=["q1"]) for f in (True, False, False)
    ]
    explains = dict(enumerate((100.0, 7.0, 15.0)))
    monkeypatch.setattr(unmodelled_structure, "_explained", lambda state, plain, which: explains[which[0]])
    kept: list[Any] = []
    given = SimpleNamespace(
        effects=tuple(kinds),
        variance_components=(),
        settings=DEFAULTS,
        background_within_scans=lambda: None,
        refitted=kept.extend,
    )
    unmodelled_structure._minor_names_dropped(given)  # type: ignore[arg-type]
    assert kept == [kinds[0], kinds[2]]


@pytest.mark.parametrize(("std", "is_found"), [(14e-6, False), (28e-6, True)])
def test_joints_that_repeat_as_well_as_any_are_no_finding(std, is_found, monkeypatch):
    """A scatter of 14 microradians is what the best data sheets state, one of 28 is more, however significant both are."""
    dataset = make_cell(seed=1, poses_per_plane=10, points_per_scan=10).dataset
    model, prepared = geometry_fit(dataset)
    found = refit(dataset, model, prepared.free, ())
    jitter = VarianceComponent("pose_jitter", std, 1e-6, 50.0, 1e-12, np.zeros((0, 1, 1)))
    given: Any = SimpleNamespace(
        residuals=found.residuals,
        model=found.model,
        variance_components=[jitter],
        settings=DEFAULTS,
        background_within_scans=lambda: None,
    )
    monkeypatch.setattr(
        components, "fit_components", lambda _, kernels: SimpleNamespace(log_likelihood=50.0 * len(kernels))
    )
    assert bool(identified_components(given)) == is_found


def test_two_more_shapes_may_imitate_a_name(monkeypatch):
    """A further shape always explains more: two are added to the first."""
    entry = scored(JointHarmonic(4, (7,)))
    given: Any = SimpleNamespace(
        effects=(entry.effect,), dataset=None, settings=DEFAULTS, background=lambda: None
    )
    given.refitted = lambda effects: SimpleNamespace(**{**vars(given), "effects": tuple(effects)})
    stand_ins: dict[str, Any] = {
        "_in_parts": lambda _: [None],
        "_ranked": lambda *_: [[entry]],
        "refined": lambda state, background, entry: entry,
        "_refined_again": lambda state, first, pool: SimpleNamespace(**{**vars(given), **vars(state)}),
        "background_without": lambda *_: None,
        "together": lambda state, terms, *_: scored(entry.effect, 10.0 * len(terms)),
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(unmodelled_structure, name, stand_in)
    monkeypatch.setattr(JointHarmonic, "partial_imitators", lambda *_: [])
    found, _ = unmodelled_structure._with_partial_imitators(given, entry.effect)
    assert len(found.effects) == 3


def test_the_few_best_terms_are_looked_at(monkeypatch):
    """Of thirty that explain about the same, more than two and fewer than eight: each costs a refit."""
    entries = [scored(JointHarmonic(4, (7,)), 100.0 - k) for k in range(30)]
    monkeypatch.setattr(unmodelled_structure, "CandidateColumns", lambda *_: None)
    monkeypatch.setattr(unmodelled_structure, "rank", lambda *_: entries)
    (found,) = unmodelled_structure._ranked(state(), [None], [None])  # type: ignore[list-item]
    assert 2 < len(found) < 8 and found == entries[: len(found)]


@pytest.mark.parametrize(("share", "left_out"), [(0.9, True), (0.96, False)])
def test_effects_are_left_out_only_where_that_is_clearly_nearer(share, left_out, monkeypatch):
    """An expected error of 90 % without one of two effects is clearly less, one of 96 % is not."""
    errors = {(0, 1): (1.0, 1.0, 1.0), (0,): (share, 1.0, 1.0)}
    assert bool(chosen(monkeypatch, errors).left_out) == left_out


@pytest.mark.parametrize(("share", "shipped"), [(0.6, 2), (0.8, 0)])
def test_what_leaves_most_of_the_error_is_not_corrected(share, shipped, monkeypatch):
    """A correction that leaves 60 % of the expected error is made, one that leaves 80 % is not."""
    errors = {(0, 1): (share, share, share), (): (1.0, 1.0, 1.0)}
    assert len(chosen(monkeypatch, errors).left_out) == 2 - shipped


def chosen(monkeypatch, errors):
    """Return what is chosen of two effects, given the expected errors of some models; those of all others are large."""
    wide = SimpleNamespace(errors=lambda kept: errors.get(kept, (10.0, 10.0, 10.0)))
    monkeypatch.setattr(focused_choice, "_Wide", lambda _: wide)
    monkeypatch.setattr(focused_choice, "_nuisances", lambda _: [])
    effects = (SimpleNamespace(generalised=lambda _: None),) * 2
    after: Any = SimpleNamespace(effects=effects, dataset=None, settings=DEFAULTS, refitted=lambda _: None)
    return focused_choice.focused_choice(after)


@pytest.mark.parametrize(("errors", "fit"), [(1.5, "equal_weights"), (3.0, "before")])
def test_the_model_without_effects_is_shipped_where_it_predicts_clearly_better(errors, fit, monkeypatch):
    """By three standard errors it does, by one and a half it does not."""
    monkeypatch.setattr(
        shipped_fit, "focused_choice", lambda state: SimpleNamespace(state=state, left_out=(), as_found=True)
    )
    monkeypatch.setattr(shipped_fit, "held_out_errors", lambda *_: None)
    monkeypatch.setattr(shipped_fit, "held_out_regions", lambda *_: None)
    monkeypatch.setattr(shipped_fit, "no_worse", lambda *_: True)
    monkeypatch.setattr(shipped_fit, "improvement_in_metres", lambda *_: errors)
    assert shipped_fit.shipped_fit(state(), state(effects=("one",)), None).fit == fit


@pytest.mark.parametrize(("share", "confirmed"), [(0.4, False), (0.6, True)])
def test_an_effect_that_few_runs_choose_is_no_finding(share, confirmed):
    """Chosen in six tenths of the runs it is confirmed, in four tenths it is not."""
    finding = Finding(JointScale(2), 1e-9, None, None, (), 0.9, (), None)  # type: ignore[arg-type]
    after: Any = SimpleNamespace(settings=DEFAULTS, refitted=lambda _: after)
    run = Explained(None, None, after, after, None)  # type: ignore[arg-type]
    outer: Any = SimpleNamespace(answers=(None,), selected_in=lambda effect: share)
    kept = DIAGNOSE._confirmed(run, (finding,), outer)[1]
    assert bool(kept) == confirmed


def test_noises_of_nearly_the_same_likelihood_are_confounded():
    """Two nats below the likeliest one is confounded with it, four nats below is not."""
    noise = [
        SimpleNamespace(name=name, log_likelihood_gain=gain, std=1e-4, std_error=1e-5, p_value=0.0)
        for name, gain in NOISES
    ]
    rms = SimpleNamespace(rms=1e-4)
    given: Any = SimpleNamespace(
        noise=noise,
        after=SimpleNamespace(settings=DEFAULTS),
        shipped=SimpleNamespace(disagreement=None, effects_held_out=rms),
        noise_grounds=SimpleNamespace(to_mapping=dict),
        noise_confidence=0.9,
        _noise_selected_in=None,
        component_is_no_noise=False,
    )
    assert [entry["name"] for entry in Diagnosis.noise_entry(given)["confounded_with"]] == ["near"]


def test_what_explains_nearly_as_much_is_confounded(monkeypatch):
    """Four nats below the effect that is named is confounded with it, seven nats below is not."""
    own = scored(JointScale(2), 100.0)
    near, far = JointHarmonic(4, (7,)), JointHarmonic(5, (7,))
    stand_ins: dict[str, Any] = {
        "as_whitened": lambda after: after,
        "CandidateColumns": lambda *_: None,
        "evidence_without_a_name": lambda *_: [[]],
        "held_out_errors": lambda _: None,
        "rivals": lambda *_: (own, [own, scored(near, 96.0), scored(far, 93.0)]),
        "has_all_orders": lambda *_: False,
        "is_shrunk": lambda _: False,
        "fold_odds": lambda *_: np.array([9.0, 3.0, 6.0]),
        "grounds_of_effect": lambda *_: None,
        "confidence": lambda _: 0.9,
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(DIAGNOSE, name, stand_in)
    after: Any = SimpleNamespace(
        effects=(own.effect,), settings=DEFAULTS, model=None, refitted=lambda *_: after
    )
    (finding,) = DIAGNOSE._findings(Explained(None, None, after, after, None), None)  # type: ignore[arg-type]
    assert finding.confounded_with == (near,)
