"""How the effects of two calibrations differ, for the terminal: those with names, and the flexible terms, which have none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.units import MM

if TYPE_CHECKING:
    from scalar.comparison import Comparison


def lines_on_unnamed_terms(comparison: Comparison) -> list[str]:
    """Return for each calibration with flexible terms what they change and how far they move positions; none if there are no such terms."""
    lines: list[str] = []
    for letter, terms in zip("AB", comparison.unnamed, strict=True):
        if terms:
            lines.append(
                f"{letter} has {_count(len(terms))} without a name, which {'corrects' if len(terms) == 1 else 'correct'} structure whose cause was "
                "not found:"
            )
        lines += [
            f"  {term.described_as}; moves predicted positions by {term.moved.rms / MM:.3f} mm RMS, at most {term.moved.largest / MM:.3f} mm"
            + ("" if term.stays_with_arm else "; it belongs to that campaign and is not compared")
            for term in terms
        ]
    return lines


def how_effects_differ(comparison: Comparison) -> str:
    """Return the note for calibrations with different effects, or with the same ones in other coefficients, and what to do."""
    return f"note: A and B {_difference(comparison)}, so what one of them lacks may look like a change; {_with_same_effects(comparison)}"


def _difference(comparison: Comparison) -> str:
    """Return how the effects of A and B differ, a predicate."""
    if not any(comparison.effects):
        return "contain different terms without a name (listed below)"
    if _are_the_same(comparison.effects):
        if any(comparison.unnamed):
            return "contain the same named effects, and different terms without a name (listed below)"
        return "contain the same effects with other coefficients"
    return "were calibrated with different effects"


def _count(number: int) -> str:
    return f"{number} term{'' if number == 1 else 's'}"


def _all_effects(comparison: Comparison) -> list[str]:
    """Return all effects of A, and those of B, in words: names for ``--effects``, and the number of terms without a name."""
    return [
        " and ".join(
            [*([named] if named else []), *([f"{_count(len(terms))} without a name"] if terms else [])]
        )
        or "none"
        for named, terms in zip(comparison.effects, comparison.unnamed, strict=True)
    ]


def positions_unexplained(comparison: Comparison) -> str:
    """Return the line for positions that differ beyond chance although no compared parameter changed: possible reasons, and what to do."""
    said = (
        f"the arm's positions differ by {comparison.positions_apart.rms / MM:.3f} mm RMS, beyond chance ({comparison.by_chance / MM:.3f} mm), "
        "though no parameter that both calibrations have has changed"
    )
    fixed = any("." in name and "fixed" in reason for name, reason in comparison.not_compared.items())
    if comparison.arm.effects_differ:
        one, other = _all_effects(comparison)
        same = any(comparison.effects) and _are_the_same(comparison.effects) and not any(comparison.unnamed)
        names = (
            f"the same effects with other coefficients: {one}"
            if same
            else f"different effects: A {one}; B {other}"
        )
        return f"{said}; they contain {names}; the note above says how to compare them"
    if fixed:
        return f"{said}; effects that were fixed cannot show a change; {_with_same_effects(comparison)}"
    return f"{said}; what may have changed stands under 'not compared'"


def with_what_it_lacks(comparison: Comparison) -> str:
    """Return which calibrations to compare instead of those of a model that lacks something."""
    how = (
        "as the note above says"
        if comparison.arm.effects_differ
        else "both by scalar calibrate with the same --effects (scalar diagnose prints them)"
    )
    return f"Compare calibrations that contain what it lacks, {how}"


def _with_same_effects(comparison: Comparison) -> str:
    """Return how to calibrate both with the same effects, all of them free, and what to do about terms that no option frees."""
    a, b = comparison.same_effects
    steps: list[str] = []
    if a:
        command = "scalar calibrate ... --effects"
        if _are_the_same(comparison.same_effects):
            how = f": {command} {a}"
        else:
            how = (
                f" of the arm, and each with those of its own set-up: A by {command} {a}; B by {command} {b}"
            )
        steps.append(f"calibrate both with the same effects{how}")
    steps += _with_terms_of_the_other(comparison)
    if not steps and any(comparison.unnamed):
        return "no option of --effects frees such a term: compare calibrations without it"
    return "; ".join(steps) or "calibrate both with the same ones"


def _with_terms_of_the_other(comparison: Comparison) -> list[str]:
    """Return how to find out whether the arm had the terms without a name of one campaign in the other too; none if no such term is of the arm."""
    having = [i for i, terms in enumerate(comparison.unnamed) if any(term.stays_with_arm for term in terms)]
    if not having:
        return []
    how = " and ".join(
        f"the campaign of {'BA'[i]} by --effects-from the calibration of {'AB'[i]}" for i in having
    )
    return [
        f"what has no name may be what changed, and no --effects frees it: calibrate {how}, which takes it over; if the residual is larger then, "
        "the arm did not have it in that campaign; if it is not, it had, or those poses do not show it"
    ]


def _are_the_same(named: tuple[str, str]) -> bool:
    """Return whether two values of ``--effects`` name the same effects, in whatever order: a diagnosis lists the strongest first."""
    a, b = (set(names.split(",")) for names in named)
    return a == b
