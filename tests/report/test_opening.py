"""The report begins with what matters most and what to do, and says each thing once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.flexible.joint import UnattributedJoint
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_ripple import JointRipple
from scalar.effects.picture import Axis, Profile
from scalar.report.opening import by_importance, caution, clauses


def found(effect: Any, before: float, after: float) -> Any:
    """Return a finding that lowers the held-out error from one value to another [m]."""
    return SimpleNamespace(
        effect=effect,
        before=SimpleNamespace(rms=before),
        after=SimpleNamespace(rms=after),
        doubtful=False,
        confidence=0.95,
        confounded_with=(),
        limit="",
    )


def test_the_largest_gain_comes_first():
    """Of two findings, the one that lowered the squared error more comes first, in whatever order they were added."""
    small, large = (
        found(JointBacklash(2, "approach"), 3e-4, 2.9e-4),
        found(JointBacklash(3, "approach"), 2.9e-4, 1e-4),
    )
    assert by_importance([small, large]) == by_importance([large, small]) == [large, small]


def test_bands_of_orders_are_one_clause():
    """Harmonics and ripples of several joints make one clause, and each joint occurs in it once."""
    joints = (1, 2, 3)
    effects = [kind(j, (orders,)) for j in joints for kind, orders in ((JointHarmonic, 3), (JointRipple, 40))]
    (text,) = clauses([found(e, 2e-4 / (k + 1), 2e-4 / (k + 2)) for k, e in enumerate(effects)], [])
    assert [text.count(str(j)) for j in joints] == [1, 1, 1]


def test_structure_without_a_name_is_told_once():
    """Five flexible terms make one clause that lists what they vary with, each joint once."""
    q = {j: Variable.observed(f"q{j}", np.linspace(-1.0, 1.0, 5)) for j in (1, 4, 6)}
    terms = [
        UnattributedJoint(j, (q[a], q[b]))
        for j, a, b in ((1, 1, 4), (2, 1, 6), (3, 4, 6), (4, 1, 4), (5, 1, 6))
    ]
    (text,) = clauses([found(term, 2e-4, 1.9e-4) for term in terms], [])
    assert text.count("structure") == 1 and text.endswith("the positions of joints 1, 4 and 6")


def test_an_unsure_cause_is_confirmed_before_anything_is_repaired():
    """A confidence below 0.8 asks for a second campaign; a sure cause, and unmodelled structure, do not."""
    diagnosis: Any = SimpleNamespace(findings=())
    for sure, asked in ((0.6, True), (0.95, False)):
        finding = found(JointBacklash(2, "approach"), 3e-4, 1e-4)
        finding.confidence, finding.confounded_with = sure, ()
        assert ("Confirm “joint 2: backlash” with a second campaign" in caution(diagnosis, finding)) is asked
    term = found(UnattributedJoint(1, (Variable.observed("q1", np.linspace(-1.0, 1.0, 5)),)), 3e-4, 1e-4)
    term.confidence, term.confounded_with = 0.5, ()
    assert not caution(diagnosis, term)


def test_a_doubtful_name_is_a_hint():
    """A doubtful name is told last, as what the structure is most like, and no repair is advised."""
    doubtful, certain = (
        found(JointBacklash(2, "approach"), 3e-4, 1e-4),
        found(JointBacklash(3, "approach"), 1e-4, 9e-5),
    )
    doubtful.doubtful, doubtful.confidence, doubtful.confounded_with = True, 0.3, ()
    first, last = clauses([doubtful, certain], [])
    assert "joint 3" in first and "no certain name; it resembles “joint 2: backlash”" in last
    warning = caution(SimpleNamespace(findings=()), doubtful)  # type: ignore[arg-type]
    assert "Look for the cause before anything is repaired" in warning and "30 %" in warning


@pytest.mark.parametrize("doubtful", [False, True])
def test_a_confidence_that_a_rule_lowered_is_no_share_of_trials(doubtful):
    """Advice on a name whose confidence a rule lowered gives the rule's reason, and does not say that so many such names were right in trials."""
    finding = found(JointBacklash(2, "approach"), 3e-4, 1e-4)
    finding.doubtful, finding.confidence, finding.confounded_with = doubtful, 0.5, ()
    assert "simulated trials" in caution(SimpleNamespace(findings=()), finding)  # type: ignore[arg-type]
    finding.limit = "the joint angles were rounded"
    told = caution(SimpleNamespace(findings=()), finding)  # type: ignore[arg-type]
    assert "50 %" in told and "because the joint angles were rounded." in told and "trials" not in told


def test_doubtful_names_of_one_kind_are_said_together():
    """Gear errors of three joints in many orders are one phrase, without a list of orders; another kind keeps its title."""
    gears = [found(JointHarmonic(joint, tuple(range(1, 33))), 3e-4, 1e-4) for joint in (3, 1, 2)]
    other = found(JointBacklash(4, "approach"), 3e-4, 1e-4)
    for finding in (*gears, other):
        finding.doubtful, finding.confidence, finding.confounded_with = True, 0.3, ()
    (clause,) = clauses([*gears, other], [])
    assert clause.endswith("it resembles “harmonic error” of joints 1, 2 and 3 or “joint 4: backlash”")


def test_an_unsure_name_is_not_stated_as_a_fact():
    """A confidence below 0.8 makes a clause a guess that lists its rivals; a sure effect of its kind stays a fact."""
    unsure, sure = (
        found(JointBacklash(2, "approach"), 3e-4, 1e-4),
        found(JointBacklash(3, "approach"), 1e-4, 9e-5),
    )
    unsure.confidence = 0.6
    guess, fact = clauses([unsure, sure], [])
    assert guess.startswith("probably ") and "joint 2" in guess and "joint 3" not in guess
    assert "joint 3" in fact and "probably" not in fact
    unsure.confounded_with = (JointHarmonic(2, (1,)),)
    guess, _ = clauses([unsure, sure], [])
    assert guess.startswith("perhaps ") and guess.endswith(
        f"do not distinguish from “{JointHarmonic(2, (1,)).title}”"
    )


def test_the_size_of_several_effects_is_that_of_the_largest():
    """Tilts have no picture and state their coefficient; sizes from pictures already say what they are."""
    tilts = [
        found(AxisNonparallel(j, coefficients=np.array([c])), 2e-4, 1e-4)
        for j, c in ((2, 3.5e-4), (3, -8e-4))
    ]
    (text,) = clauses(tilts, [])
    assert "(up to 0.046" in text
    waves = [
        found(JointHarmonic(j, (2,), coefficients=np.array([1e-3 * j, 0.0])), 2e-4, 1e-4) for j in (2, 3)
    ]
    x = np.linspace(-1.0, 1.0, 60)
    zero = np.zeros(60)
    drawn = [
        [Profile(Axis("joint angle", "rad"), Axis("error", "rad"), x, size * x, zero, zero, size * x)]
        for size in np.deg2rad([0.06, 0.17])
    ]
    (text,) = clauses(waves, drawn)
    assert "up to up to" not in text
    assert "0.17" in text
