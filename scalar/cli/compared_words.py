"""What two calibrations were compared in, for the terminal: parameters and effects, and those that were not compared, with the reason."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scalar.comparison import Comparison
    from scalar.effects import Effect

_NOT_COMPARED_SHOWN = 8


def what_was_compared(comparison: Comparison) -> list[str]:
    """Return a line with all that was compared, one for each calibration with what it alone has, and the lines on what was not compared."""
    geometry = [named_parameter(comparison, name) for name in comparison.compared if "." not in name]
    coefficients = [name for name in comparison.compared if "." in name]
    effects = _effects_of(coefficients)
    listed = [
        f"{_count(len(geometry), 'parameter')} of the geometry{_in_brackets(geometry)}",
        f"{_count(len(effects), 'effect')}{_in_brackets(effects)}"
        + (f" with {_count(len(coefficients), 'coefficient')}" if effects else ""),
    ]
    by_positions = list(dict.fromkeys(effect.name for effect in comparison.disjoint_terms))
    if by_positions:
        listed.append(f"by the positions that they cause, {', '.join(by_positions)}")
    lines = [f"compared: {'; '.join(listed)}"]
    apart = {name for effect in comparison.disjoint_terms for name in effect.parameters}
    for letter, names in zip("AB", comparison.arm.only_in, strict=True):
        own = [name for name in names if name not in apart]
        if own:
            shown = [named_parameter(comparison, name) for name in own if "." not in name]
            shown += _effects_of([name for name in own if "." in name])
            lines.append(f"in {letter} only: {_first(shown)}")
    return lines + _not_compared(comparison)


def lines_on_what_to_do(comparison: Comparison) -> list[str]:
    """Return the line on what follows if parameters of the arm changed; none if none did."""
    names = [change.candidate.name for change in comparison.changes]
    if not names:
        return []
    zeros = any(name.startswith("theta_") for name in names)
    mastered = " (a zero: master the joint again)" if zeros else ""
    return [
        f"  what to do: use B from now on, which describes the arm as it is; or have the arm put right{mastered}, and measure a campaign afterwards, "
        "because neither A nor B holds then"
    ]


def lines_on_stretch(comparison: Comparison) -> list[str]:
    """Return the lines on a factor between all lengths of the two calibrations, and what may be its cause; none if there is none."""
    stretch = comparison.stretch
    if stretch is None:
        return []
    from scalar.report.words import LEAST_P_VALUE
    from scalar.units import MM

    chance = f"p < {LEAST_P_VALUE:.0e}" if stretch.p_value < LEAST_P_VALUE else f"p = {stretch.p_value:.1g}"
    longer = "longer" if stretch.value > 0 else "shorter"
    return [
        f"  all lengths of B are {100 * abs(stretch.value):.4f} +- {100 * stretch.std:.4f} % {longer} than those of A; this moves predicted "
        f"positions by {stretch.moved.rms / MM:.3f} mm RMS, at most {stretch.moved.largest / MM:.3f} mm ({chance})",
        "    an instrument that measured too long or too short in one campaign does this, or another temperature of the arm, and no data show which: "
        "check scanner, probe or tracker against a known length before a change of the arm is looked for",
    ]


def _effects_of(coefficients: Sequence[str]) -> list[str]:
    """Return the names of the effects that coefficients belong to, each once."""
    from scalar.effects.parameter_names import effect_of

    return list(dict.fromkeys(effect_of(name) for name in coefficients))


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def _in_brackets(names: Sequence[str]) -> str:
    return f" ({', '.join(names)})" if names else ""


def _first(names: Sequence[str]) -> str:
    """Return names in a row, those beyond the first few as their number."""
    more = len(names) - _NOT_COMPARED_SHOWN
    return ", ".join(names[:_NOT_COMPARED_SHOWN]) + (f" and {more} more" if more > 0 else "")


def unchanged_effects(comparison: Comparison) -> list[str]:
    """Return a line with the effects whose coefficients were all compared and did not change beyond chance; none where there are none."""
    from scalar.effects.command_line import named_effects

    left = {i for change in comparison.changes for i in change.candidate.columns}
    model = comparison.arm.model
    names = {name: i for i, name in enumerate(comparison.arm.names)}
    apart = {name for effect in comparison.disjoint_terms for name in effect.parameters}
    same = [
        effect
        for effect, own in zip(model.effects, model.effect_names, strict=True)
        if all(
            name in names
            and names[name] not in left
            and name not in comparison.not_compared
            and name not in apart
            for name in own
        )
    ]
    return [f"compared, and not changed beyond chance: {named_effects(same)}"] if named_effects(same) else []


def size_grows(comparison: Comparison, index: int) -> float | None:
    """Return the sign of the change with which a parameter's size grows, if reports show it by its size, as the half width of play; else None."""
    model = comparison.arm.model
    name = comparison.arm.names[index]
    for effect, own in zip(model.effects, model.effect_names, strict=True):
        if name in own and effect.sign_in_words:
            return -1.0 if float(effect.coefficients[own.index(name)]) < 0 else 1.0
    return None


def named_parameter(comparison: Comparison, name: str) -> str:
    """Return a parameter's name; if dataset.yaml has standard DH, by the row of that table."""
    from scalar.geometry.standard_dh import as_stated

    return as_stated(name, comparison.arm.model.nominal)


def _not_compared(comparison: Comparison) -> list[str]:
    """Return the parameters and effects that were not compared, one line for each reason; an effect stands there once, whatever its coefficients."""
    from scalar.effects.parameter_names import effect_of

    by_reason: dict[str, dict[str, None]] = {}
    for name, reason in comparison.not_compared.items():
        shown = effect_of(name) if "." in name else named_parameter(comparison, name)
        by_reason.setdefault(reason, {})[shown] = None
    lines = []
    for reason, found in by_reason.items():
        lines.append(f"not compared: {_first(list(found))}: {named_parameter(comparison, reason)}")
    return lines


def effects_by_candidate(comparison: Comparison) -> dict[str, Effect]:
    """Return the effects of the arm by the names of their candidates."""
    from scalar.effects.parameter_names import effect_of

    model = comparison.arm.model
    return {
        effect_of(own[0]): effect
        for effect, own in zip(model.effects, model.effect_names, strict=True)
        if own
    }
