"""What effects say of themselves reads as sentences: a verb in each, nothing twice, advice that one can act on, nobody sent to the wrong maker."""

from __future__ import annotations

import re

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.effect import Effect
from scalar.effects.flexible.first_steps import first_steps
from scalar.effects.places import PointEffect
from scalar.effects.registry import known
from tests.effects.everything import every_effect, optional_columns
from tests.effects.injected import make_cell
from tests.random_scene import make_scene

VERBS = {
    "is", "are", "was", "has", "have", "errs", "err", "gives", "give", "tilts", "grow", "moved", "stood", "crept", "slipped", "sat", "rests",
    "turns", "turn", "measures", "explains", "varies",
}  # fmt: skip
"""Finite verbs of which every sentence on an effect has one; a new effect may add its own."""

IMPERATIVES = {
    "Add", "Check", "Clamp", "Compare", "Correct", "Give", "Have", "Let", "Measure", "Record", "Repeat", "Replace", "Scan", "Sweep",
    "Tighten", "Turn", "Wait",
}  # fmt: skip
"""Words with which advice begins: what to do."""

JOINT = re.compile(r"\bjoints? \d")


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    """Return a small dataset with every optional column."""
    return make_cell(seed=5, poses_per_plane=8, points_per_scan=6, columns=optional_columns).dataset


@pytest.fixture(scope="module")
def effects(dataset: Dataset) -> list[Effect]:
    """Return one of every effect."""
    return every_effect(dataset, np.random.default_rng(6))


def faults(text: str) -> list[str]:
    """Return what breaks a text: words or marks twice, a gap before a mark, something empty."""
    found = [word for word in re.findall(r"\b(\w+) \1\b", text, re.IGNORECASE) if not word.isdigit()]
    found += re.findall(r"\s[,.;:)]|\(\s*\)|[,;:.]{2}|\s{2}|^\s|\s$|\bNone\b|\bnan\b", text)
    return found


def words_of(text: str) -> set[str]:
    """Return the words of a text."""
    return set(re.findall(r"\w+", text))


def test_faults_are_found():
    """The rules find a repeated word, an empty bracket and a lost end, and find no fault in a plain sentence."""
    assert (
        faults("the the joint")
        and faults("joint 1 errs ()")
        and faults("it errs .")
        and faults("varies with None")
    )
    assert not faults("joint 1 errs periodically, with 3 periods a turn (up to 0.017°)")


def test_clauses_and_sentences_have_a_verb_and_no_fault(effects):
    """Each clause has a verb, begins with a small letter, ends without a full stop, and repeats nothing."""
    for effect in effects:
        for text in (effect.clause, effect.sentence, effect.clause_of([effect])):
            assert words_of(text) & VERBS, text
            assert not faults(text), text
            assert text[0].islower() and not text.endswith("."), text


def test_several_effects_of_a_kind_are_one_clause(effects):
    """However many effects there are, nothing is repeated, and the verb agrees with the number of joints."""
    for effect in effects:
        assert effect.clause_of([effect] * 5).count(effect.clause_of([effect])) <= 1
        alike = [e for e in effects if (e.reported_with or e.name) == (effect.reported_with or effect.name)]
        text = alike[0].clause_of(alike)
        assert words_of(text) & VERBS and not faults(text), text
        assert not re.search(r"\bjoints [\d, and]+ (errs|gives|has)\b|\bjoint \d (err|give|have)\b", text), (
            text
        )


def test_advice_says_what_to_do(effects):
    """Every effect has advice in whole sentences, and the first of them begins with what to do."""
    for effect in effects:
        assert effect.advice, effect.name
        assert effect.advice[0].split()[0] in IMPERATIVES, effect.advice[0]
        for text in effect.advice:
            assert text[0].isupper() and text.endswith(".") and not faults(text), text


def test_every_effect_says_how_to_see_it_and_what_changes_in_the_controller(effects):
    """Both texts are whole sentences; a flexible term has neither, since its advice is how to find its cause."""
    for effect in [effect for effect in effects if not effect.flexible]:
        for text in (effect.how_to_measure, effect.in_controller):
            assert text[:1].isupper() and text.endswith(".") and not faults(text), (effect.name, text)


def test_a_fault_of_scanner_or_plane_sends_nobody_to_the_arm(effects):
    """Advice on errors of the points names the scanner or the plane, and neither a joint nor a gear."""
    for effect in effects:
        if isinstance(effect, PointEffect):
            text = " ".join([effect.sentence, effect.clause, *effect.advice, effect.how_to_measure])
            assert "asks for no change in the controller" in effect.in_controller
            assert not JOINT.search(text) and "gear" not in text and "robot" not in text, text
            assert "scanner" in text or "target plane" in text, text


@pytest.mark.parametrize("alike", [True, False])
def test_a_tilting_base_names_the_masses_that_tilt_it(alike):
    """A row of its table says along which axis of which frame the masses lie, and no two rows say the same."""
    effect = BaseCompliance((2, 3), alike)
    table = effect.table([None] * len(effect.coefficients))
    assert table is not None
    names = [row[0] for row in table[1]]
    assert len(set(names)) == len(effect.coefficients)
    assert all(re.search(r"masses along [xy] of frame [23]$", name) for name in names)


@pytest.mark.parametrize(
    "name", ["q2", "gravity", "order", "time", "temperature", "plane_u", "plane_v", "humidity"]
)
def test_structure_without_a_name_has_first_steps(name):
    """Whatever columns unmodelled structure varies with, one sentence says what to do, and each sentence occurs once."""
    (text,) = first_steps([name, name])
    assert text.split()[0] in IMPERATIVES and text.endswith(".") and not faults(text)


def test_texts_for_a_tracker_do_not_mention_planes_or_scans():
    """No effect that is tried on a tracker's data, and no advice on its columns, speaks of planes or scans."""
    data = make_scene(kind="tracker", seed=1, poses_per_plane=8).dataset
    for kind in known().values():
        tried = [*kind.candidates(data), *(effect for effect, _ in kind.changes(data))]
        texts = [
            text
            for e in tried
            for text in (e.title, e.clause, e.sentence, *e.advice, e.how_to_measure, e.in_controller)
        ]
        for text in [*texts, *kind.advice_on_data(data)]:
            assert not words_of(text.lower()) & {"plane", "planes", "scan", "scans", "scanner"}, text
