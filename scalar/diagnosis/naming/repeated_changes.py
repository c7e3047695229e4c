"""Lower the confidence in names that are given several times: a single cause that no effect describes is more probable than so many of one kind.

A target plane is knocked, or a sensor slips, by accident and at one moment. A base that sways or an encoder that drifts acts all the time. Several
changes at different moments then approximate its effect, as the steps of a staircase approximate a slope. The evidence for each change is large, but
all their names are wrong. A plane that creeps aside within some poses is one accident, though: a change in the middle explains nearly all of it, and
a further change of the same plane a small rest. The name of the first stays then.

Any other effect acts at a place once and all the time. If it is found twice at one place (two warm-ups of the arm, or play twice in one joint), its
form is not that of the cause: the second describes the part of the cause that the first does not fit. Growth of the arm has two names, with stops and
without (``Effect.growth_of_arm``). If one of them is found several times, the other describes a further part of the same growth: an arm whose motors
and links warm up one after the other had got three warm-ups with stops, each doubtful, and also a thermal drift with a confidence of 0.99.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from scalar.diagnosis.naming.finding import Finding
from scalar.effects import registry

_SEVERAL = (
    "the name is given several times, and one cause without a name is more probable than so many of one kind"
)
NEARLY_ALL = 10.0  # chosen: times what all other changes of its kind explain, from which on a change is the whole accident
MOST_ACCIDENTS = 2  # changes of one kind in a campaign, each at another place, that may be accidents


def repeated_changes_doubted(found: Sequence[Finding], least_confidence: float) -> tuple[Finding, ...]:
    """Return the findings; if a name is given more often than one cause of its kind can explain, the confidence in each is divided by their number.

    Args:
        found: All findings.
        least_confidence: A repeated name with no more confidence is doubtful.
    """
    result = []
    times_of = iter(repetitions([(f.effect.name, f.effect.target) for f in found if not f.effect.flexible]))
    for f in found:
        times = 1 if f.effect.flexible else next(times_of)
        times = 1 if times > 1 and _is_the_whole(f, found) else times
        confidence = f.confidence / times
        doubtful = f.doubtful or (times > 1 and confidence <= least_confidence)
        limit = _SEVERAL if times > 1 else f.limit
        result.append(replace(f, confidence=confidence, doubtful=doubtful, limit=limit))
    return tuple(result)


def _is_the_whole(finding: Finding, found: Sequence[Finding]) -> bool:
    """Return whether a change at a moment explains nearly all that the changes of its kind do, all of which are at its place."""
    effect = finding.effect
    others = [f for f in found if f is not finding and f.effect.name == effect.name]
    one_place = all(_place(f.effect.target) == _place(effect.target) for f in others)
    explained = _explained(finding) > NEARLY_ALL * sum(map(_explained, others))
    return "at" in effect.target and one_place and explained


def _explained(finding: Finding) -> float:
    """Return what a finding explains over what is left of the residual, as ratio of sums of squares."""
    share = min(finding.grounds.share, 1.0 - 1e-12)
    return share / (1.0 - share)


def repetitions(answers: Sequence[tuple[str, Mapping[str, Any]]]) -> list[int]:
    """Return for each answer (name, target) the number of answers that one cause would explain better; one if each may have its own.

    Changes at a moment may each have their own cause if there are at most ``MOST_ACCIDENTS`` of a kind and each is at another place; other effects
    if each is at another place. A change at a moment and one that lasts are at one place where both are of one kind: a tracker that drifts and is
    knocked as well.
    """
    result = []
    for name, target in answers:
        of_kind = [other for kind, other in answers if kind == name]
        places = [_place(other) for other in of_kind]
        if "at" not in target:
            result.append(_of_one_growth(name, answers) or places.count(_place(target)))
            continue
        again = any(place in places[:i] for i, place in enumerate(places))
        many = again or sum("at" in other for other in of_kind) > MOST_ACCIDENTS
        result.append(len(places) if many else 1)
    return result


def _of_one_growth(name: str, answers: Sequence[tuple[str, Mapping[str, Any]]]) -> int:
    """Return the number of growths among answers if the name is that of one, and one of their names is given several times; else zero."""
    growths = {kind.name for kind in registry.known().values() if kind.growth_of_arm}
    given = [other for other, _ in answers if other in growths]
    several = max((given.count(growth) for growth in growths), default=0) > 1
    return len(given) if name in growths and several else 0


def _place(target: Mapping[str, Any]) -> dict[str, Any]:
    """Return where an effect acts, whenever that is."""
    return {key: value for key, value in target.items() if key != "at"}
