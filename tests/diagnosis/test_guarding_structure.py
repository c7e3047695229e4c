"""Thresholds of unmodelled structure: each is tested with numbers on both sides of it, so that half or double the threshold changes the decision.

``snakemake sensitivity`` names these tests for thresholds on which no blind set depends.
"""

from types import SimpleNamespace
from typing import Any

import pytest

from scalar.diagnosis.settings import DEFAULTS
from scalar.diagnosis.structure import dropped_effects, ranked_terms, replaced_names, unmodelled_structure
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import Tried, scored, state


@pytest.mark.parametrize(("chance", "is_tried"), [(7e-6, True), (15e-6, False)])
def test_a_flexible_term_has_to_be_highly_significant(chance, is_tried, monkeypatch):
    """A flexible term with a p-value of seven in a million is tried, and one with fifteen in a million is not."""
    entry = scored(JointHarmonic(4, (7,)), p_value=chance)
    monkeypatch.setattr(unmodelled_structure, "ranked_once", lambda *_: [[entry]])
    monkeypatch.setattr(unmodelled_structure, "refined", lambda state, background, entry: entry)
    given = state(background=lambda: None, effects=())
    if is_tried:
        with pytest.raises(Tried):
            unmodelled_structure._with_best(given, [])
    else:
        assert unmodelled_structure._with_best(given, []) is None


def replacing(monkeypatch: Any, evidence: float, dof: int, gain: float = 0.0) -> list[str]:
    """Return what was done to replace a named effect: ``refitted``, ``several`` and ``replaced``.

    Args:
        monkeypatch: The fixture of the test.
        evidence: Of a flexible term in the place of the effect, whose own is 100.
        dof: Number of coefficients of the effect; the term has as many, so that it is compared with all of the effect's evidence.
        gain: Evidence of the refitted model with the term, less that of the model with the effect.
    """
    done: list[str] = []
    named = JointHarmonic(4, (7,))
    given: Any = SimpleNamespace(effects=(named,), dataset=None, settings=DEFAULTS, whitening=None)
    trial: Any = SimpleNamespace(is_plausible=True)
    given.background = lambda: None
    given.refitted = lambda effects: done.append("refitted") or trial
    stand_ins: dict[str, Any] = {
        "_evidence_of": lambda state, *_: gain if state is trial else 0.0,
        "background_without": lambda *_: (None, None, None),
        "score_together": lambda *_: scored(named, 100.0, dof=dof),
        "ranked_once": lambda *_: [[scored(JointScale(4), evidence, dof=dof)], []],
        "imitating": lambda *_: [],
        "refined_once": lambda state, background, entry: entry,
        "_with_partial_imitators": lambda *_: done.append("several") or (None, 0.0),
        "held_out_errors": lambda *_: SimpleNamespace(rms=1.0),
        "improvement": lambda *_: 0.0,
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(replaced_names, name, stand_in)
    monkeypatch.setattr(JointHarmonic, "imitators", lambda *_: [JointScale(4)])
    monkeypatch.setattr(JointHarmonic, "partial_imitators", lambda *_: [JointScale(4)])
    if replaced_names.with_replacement(given, None, [None]) is trial:  # type: ignore[arg-type,list-item]
        done.append("replaced")
    return done


def test_a_name_is_replaced_only_where_the_refitted_model_explains_the_data_better(monkeypatch):
    """The term alone scores far better than the named effect. It replaces the effect if the refitted model has 10 nats more evidence, and not if it
    has 5.
    """
    assert "replaced" in replacing(monkeypatch, 150.0, dof=2, gain=10.0)
    assert "replaced" not in replacing(monkeypatch, 150.0, dof=2, gain=5.0)


def test_a_term_that_explains_far_less_than_a_name_is_not_refined(monkeypatch):
    """A term with 60 % of the named effect's evidence is not refined, and one with 80 % is."""
    assert not replacing(monkeypatch, 60.0, dof=2)
    assert "refitted" in replacing(monkeypatch, 80.0, dof=2)


def test_several_shapes_are_not_tried_in_the_place_of_a_spectrum(monkeypatch):
    """Several shapes are tried in the place of six orders, and not in that of twelve."""
    assert "several" in replacing(monkeypatch, 80.0, dof=12)
    assert "several" not in replacing(monkeypatch, 80.0, dof=24)


@pytest.mark.parametrize("plausible", [True, False])
def test_a_minor_effect_is_dropped(monkeypatch, plausible):
    """An effect that explains 7 % of what a flexible term explains is dropped unless the others then become implausible; one of 15 % is kept."""
    kinds = [
        SimpleNamespace(flexible=f, is_change_in_time=False, depends_on=["q1"]) for f in (True, False, False)
    ]
    explains = dict(enumerate((100.0, 7.0, 15.0)))
    monkeypatch.setattr(dropped_effects, "_explained", lambda state, plain, which: explains[which[0]])
    kept: list[Any] = []
    smaller = SimpleNamespace(is_plausible=plausible)
    given = SimpleNamespace(
        effects=tuple(kinds),
        variance_components=(),
        settings=DEFAULTS,
        background_within_scans=lambda: None,
        refitted=lambda effects: kept.extend(effects) or smaller,
    )
    monkeypatch.setattr(dropped_effects, "held_out_errors", lambda state: SimpleNamespace(rms=1.0))
    found: Any = dropped_effects.without_minor_effects(given)  # type: ignore[arg-type]
    assert kept == [kinds[0], kinds[2]]
    assert found is (smaller if plausible else given)
    # An effect without which held-out poses are predicted much worse is no part of what the flexible term describes.
    grown = {id(given): 1.0, id(smaller): 1.5}
    monkeypatch.setattr(
        dropped_effects, "held_out_errors", lambda state: SimpleNamespace(rms=grown[id(state)])
    )
    assert dropped_effects.without_minor_effects(given) is given  # type: ignore[arg-type]


def test_two_more_shapes_may_imitate_a_name(monkeypatch):
    """If a further shape always explains more, two shapes are added to the first."""
    entry = scored(JointHarmonic(4, (7,)))
    given: Any = SimpleNamespace(
        effects=(entry.effect,), dataset=None, settings=DEFAULTS, background=lambda: None
    )
    given.refitted = lambda effects: SimpleNamespace(**{**vars(given), "effects": tuple(effects)})
    stand_ins: dict[str, Any] = {
        "in_parts": lambda _: [None],
        "rank_terms": lambda *_: [[entry]],
        "refined_once": lambda state, background, entry: entry,
        "_refined_again": lambda state, first, pool: SimpleNamespace(**{**vars(given), **vars(state)}),
        "background_without": lambda *_: None,
        "score_together": lambda state, terms, *_: scored(entry.effect, 10.0 * len(terms)),
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(replaced_names, name, stand_in)
    monkeypatch.setattr(JointHarmonic, "partial_imitators", lambda *_: [])
    found, _ = replaced_names._with_partial_imitators(given, entry.effect)
    assert len(found.effects) == 3


def test_only_the_few_best_terms_are_tried(monkeypatch):
    """Of thirty terms that explain about the same, more than two and fewer than eight are tried, because each costs a refit."""
    entries = [scored(JointHarmonic(4, (7,)), 100.0 - k) for k in range(30)]
    monkeypatch.setattr(ranked_terms, "CandidateColumns", SimpleNamespace(of=lambda *_: None))
    monkeypatch.setattr(ranked_terms, "rank", lambda *_: entries)
    (found,) = ranked_terms.rank_terms(state(), [None], [None])  # type: ignore[list-item]
    assert 2 < len(found) < 8 and found == entries[: len(found)]
