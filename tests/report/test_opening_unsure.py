"""What is not sure is not said to be found: neither by the verdict in words, nor by the first sentence."""

from types import SimpleNamespace
from typing import Any

import pytest

from scalar.effects.joint_backlash import JointBacklash
from scalar.report import opening


def found(joint: int, confidence: float) -> Any:
    """Return a finding of play with a confidence and without rivals."""
    return SimpleNamespace(
        effect=JointBacklash(joint, "approach"),
        before=SimpleNamespace(rms=3e-4),
        after=SimpleNamespace(rms=1e-4),
        doubtful=False,
        confidence=confidence,
        confounded_with=(),
        limit="",
    )


@pytest.mark.parametrize(
    ("confidences", "verdict"),
    [((0.95, 0.9), opening.FOUND), ((0.95, 0.5), opening.IN_PART), ((0.5, 0.5), opening.UNSURE)],
)
def test_the_verdict_says_whether_every_name_is_sure(monkeypatch, confidences, verdict):
    """Beside a sure name, one that is right every second time is not called found."""
    monkeypatch.setattr(opening, "unexplained_excess", lambda diagnosis: [])
    diagnosis: Any = SimpleNamespace(findings=[found(k + 1, c) for k, c in enumerate(confidences)])
    assert opening.verdict_on_effects(diagnosis) == verdict


@pytest.mark.parametrize(("confidence", "word"), [(0.5, "perhaps "), (0.7, "probably "), (0.95, "joint 2")])
def test_a_name_that_is_wrong_every_second_time_is_not_probable(confidence, word):
    """The first sentence says "probably" only of what is more often right than wrong."""
    (clause,) = opening.clauses([found(2, confidence)], [])
    assert clause.startswith(word)
