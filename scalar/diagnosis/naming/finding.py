"""One finding of a diagnosis, and how ``diagnosis.json`` writes it: under its name, or as unattributed where the name is doubtful.

If the name of a finding is more probably wrong than right, its entry has the name ``unattributed``, and ``most_like`` lists the effect that it
resembles most. The correction still contains that effect, because held-out poses decide what is shipped, and names do not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from scalar.diagnosis.held_out.hold_out import HeldOutErrors
from scalar.diagnosis.naming.grounds import Grounds
from scalar.effects import Effect, registry
from scalar.effects.effect import WEIGHT
from scalar.effects.title import joints_of
from scalar.units import MM

UNATTRIBUTED = "unattributed"  # the verdict, and the name of an entry, where structure has no name


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect that was found.

    Attributes:
        effect: The effect, with its coefficients.
        p_value: p-value of its gain given the other effects, corrected for the number of all candidates.
        before: Held-out errors without it, given the effects that were added before it.
        after: Held-out errors with it, given the same effects.
        confounded_with: Effects that would explain the same as well.
        confidence: Estimated probability that name and target are right.
        std: ``(k,)``, standard errors of the coefficients, None for those that were not estimated.
        grounds: The numbers from which the confidence is computed.
        selected_in: Share of the outer split's runs that chose it at its place, or None without that split.
        limit: Why its confidence is no larger, as a clause, if a rule lowered it; else empty.
        doubtful: Whether its name is too uncertain to be given, so that it is reported as unattributed: the probability that it, or an effect that is
            confounded with it, is the cause is below ``settings.naming.least_confidence``.
    """

    effect: Effect
    p_value: float
    before: HeldOutErrors
    after: HeldOutErrors
    confounded_with: tuple[Effect, ...]
    confidence: float
    std: tuple[float | None, ...]
    grounds: Grounds
    selected_in: float | None = None
    limit: str = ""
    doubtful: bool = False

    def limited(self, most: float, least_confidence: float, reason: str) -> Finding:
        """Return the finding with its confidence limited; its name is doubtful if the limit is less than a name needs.

        Args:
            most: The limit, between 0 and 1.
            least_confidence: A name with less confidence is doubtful, between 0 and 1.
            reason: Why the confidence is no larger, as a clause.
        """
        doubtful = self.doubtful or most < least_confidence
        if most >= self.confidence:
            return replace(self, doubtful=doubtful)
        return replace(self, confidence=most, doubtful=doubtful, limit=reason)

    @property
    def has_name(self) -> bool:
        """Return whether it is reported under the name of a known effect."""
        return not (self.effect.flexible or self.doubtful)

    @property
    def is_known_deflection(self) -> bool:
        """Return whether it is a known effect by which something gives way under the weight of the arm, whether its name is doubtful or not."""
        return self.effect.load == WEIGHT and not self.effect.flexible

    @property
    def depends_on(self) -> list[str]:
        """Return the columns of ``poses.csv`` with which it varies: those of its effect, its joints, and the order if it begins at a pose."""
        target = self.effect.target
        by_order = self.effect.follows_order and not self.effect.moves_from
        moment = ["order"] if "at" in target or by_order else []
        return list(
            dict.fromkeys([*self.effect.depends_on, *(f"q{joint}" for joint in joints_of(target)), *moment])
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return its entry in ``diagnosis.json``, under the name of its effect."""
        effect = self.effect
        module = registry.module_of(effect)
        return {
            "name": effect.name,
            **({} if module is None else {"module": module}),
            "target": effect.target,
            "coefficients": {
                name: {"value": value, "std": std} for name, (value, std) in effect.stated(self.std).items()
            },
            "p_value": self.p_value,
            "held_out_rms_before_mm": self.before.rms / MM,
            "held_out_rms_after_mm": self.after.rms / MM,
            "confounded_with": [{"name": e.name, "target": e.target} for e in self.confounded_with],
            "confidence": self.confidence,
            "grounds": self.grounds.to_mapping(),
            "selected_in": self.selected_in,
        }


def limited_where(
    found: Sequence[Finding],
    applies: Callable[[Finding], bool],
    most: float,
    least_confidence: float,
    reason: str,
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in those to which a rule applies (``Finding.limited``).

    Args:
        found: All findings.
        applies: Whether the rule applies to a finding.
        most: The limit, between 0 and 1.
        least_confidence: A name with less confidence is doubtful, between 0 and 1.
        reason: Why the confidence is no larger, as a clause.
    """
    return tuple(f.limited(most, least_confidence, reason) if applies(f) else f for f in found)


def names_limited(
    found: Sequence[Finding], most: float, least_confidence: float, reason: str
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each name; flexible terms, which have none, are unchanged. Arguments as above."""
    return limited_where(found, lambda f: not f.effect.flexible, most, least_confidence, reason)


def unattributed_entry(
    findings: Sequence[Finding], component: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return the one entry of ``diagnosis.json`` for all findings without a name.

    Args:
        findings: Flexible terms and doubtful findings, in the order in which they were added.
        component: Entry of a variance component whose name is doubtful, or None; needed if there are no findings.
    """
    flexible = [finding for finding in findings if finding.effect.flexible]
    doubtful = [finding.to_mapping() for finding in findings if finding.doubtful]
    doubtful += [dict(component)] if component else []
    entry = flexible[0].to_mapping() if flexible else dict(doubtful[0])
    if findings:
        entry["held_out_rms_before_mm"] = findings[0].before.rms / MM
        entry["held_out_rms_after_mm"] = findings[-1].after.rms / MM
    if not flexible:
        entry["confidence"] = 1.0 - max(like["confidence"] for like in doubtful)
    columns = dict.fromkeys(column for finding in findings for column in finding.depends_on)
    return entry | {
        "name": UNATTRIBUTED,
        "target": {},
        "coefficients": {},
        "confounded_with": [],
        "depends_on": list(columns),
        "corrected_by_flexible_term": bool(flexible),
        "most_like": doubtful,
    }
