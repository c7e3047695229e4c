"""``scalar compare``: what changed in the arm between two calibrations, beyond chance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from scalar.cli.compared_effects import (
    lines_on_unnamed_terms,
    positions_unexplained,
    with_what_it_lacks,
)
from scalar.cli.compared_models import is_lacking, notes_on_models
from scalar.cli.compared_words import (
    effects_by_candidate,
    lines_on_stretch,
    lines_on_what_to_do,
    named_parameter,
    size_grows,
    unchanged_effects,
    what_was_compared,
)
from scalar.cli.group import cli
from scalar.cli.options import EFFECTS_MODULE, PATH, Number, load_effects
from scalar.cli.outputs import FORCE, json_of, refuse_foreign
from scalar.cli.terminal import say
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.comparison import Comparison
    from scalar.comparison.changes import Change
    from scalar.comparison.disjoint_terms import DisjointTerms
    from scalar.comparison.moved import Moved

_KINDS = {"a": "length", "alpha": "twist", "d": "offset", "theta": "zero", "beta": "tilt about y"}
_RIVALS_SHOWN = 4
# An effect with more coefficients is described by how far they move positions together, which a person can judge better.
_COEFFICIENTS_SHOWN = 2
_NONE: Mapping[str, float] = {}
_BENT = (
    "; if the sensor stayed on the flange in between, it was bent there or has slipped, and so may have been a tool that shares its mount: teach "
    "its centre point again"
)
_SHOWS_A_SHIFT = 0.1  # mm; a smaller difference of the sensor's place needs no explanation


@cli.command()
@click.argument("a", type=PATH)
@click.argument("b", type=PATH)
@click.option("-o", "--output", type=PATH, metavar="FILE.json", help="Also write the comparison as JSON.")
@click.option(
    "--alpha",
    type=Number(0.0, 0.5, min_open=True),
    default=0.01,
    show_default=True,
    help="Probability that any change is named although nothing changed, over all parameters together.",
)
@FORCE
@EFFECTS_MODULE
def compare(
    a: Path, b: Path, output: Path | None, alpha: float, force: bool, effects_modules: Sequence[Path]
) -> None:
    """Say what changed in the arm between two calibrations.

    A and B are calibration.json (or after.json) of two campaigns with the same arm, the earlier one first: of a yearly
    check, say, or before and after a crash or the exchange of a motor. The standard errors of both distinguish a change from chance. A motion
    of the base, of the sensor on its flange or of the planes between the campaigns is no change of the arm. For each
    change the output says how far it moves predicted positions.

    Calibrate both with the same --effects: an effect that only one of them has, or that --effects-from fixed, is not compared.

    \b
    Example:
      scalar compare 2025/calibration.json 2026/calibration.json -o changes.json
    """
    from scalar.comparison import compare
    from scalar.data.io.atomic import write_json
    from scalar.estimation.result import load_calibration
    from scalar.estimation.usual_noise import exceeds_usual_noise

    if output is not None:
        refuse_foreign([(output, json_of("comparison"))], force, [a, b])
    load_effects(effects_modules)
    calibrations = load_calibration(a), load_calibration(b)
    found = compare(*calibrations, alpha)
    say(f"A: {a}\nB: {b}")
    if a.read_bytes() == b.read_bytes():
        say("note: A and B are the same calibration; give those of two campaigns")
    residuals = {
        letter: calibration.residual_rms
        for letter, calibration in zip("AB", calibrations, strict=True)
        if exceeds_usual_noise(calibration)
    }
    say("\n".join(describe_comparison(found, residuals)))
    if output is not None:
        write_json(output, found.to_mapping())
        say(f"written: {output}")


def describe_comparison(comparison: Comparison, residuals: Mapping[str, float] = _NONE) -> list[str]:
    """Return lines on what changed, for the terminal.

    Args:
        comparison: The comparison.
        residuals: The residual [m] of A or B by letter, where it is more than instruments of the kind scatter by, and no noise is known.
    """
    lacking = is_lacking(comparison, residuals)
    return [
        *notes_on_models(comparison, residuals),
        _headline(comparison, lacking),
        *_caution(comparison, lacking),
        *lines_on_stretch(comparison),
        *_changes(comparison),
        *([] if lacking or comparison.arm.effects_differ else lines_on_what_to_do(comparison)),
        *unchanged_effects(comparison),
        *lines_on_unnamed_terms(comparison),
        *(line for effect in comparison.disjoint_terms for line in _by_positions(effect)),
        _positions_line(comparison),
        _sensor_line(comparison),
        *what_was_compared(comparison),
    ]


def _headline(comparison: Comparison, lacking: bool) -> str:
    """Return the line that says whether anything changed; ``lacking`` says whether a model lacks something."""
    doubtful = lacking or comparison.arm.effects_differ
    what = "the calibrations differ" if doubtful else "the arm changed"
    if n := len(comparison.changes):
        return f"{what}: {n} {'difference' if doubtful else 'change'}{'s' if n > 1 else ''} beyond chance"
    if comparison.changed:
        return f"{what} beyond chance, but no single parameter explains it"
    if comparison.stretch is not None:
        return "all lengths differ by one factor beyond chance, and no single part of the arm does"
    if comparison.positions_changed:
        return positions_unexplained(comparison)
    rest = " in what was compared (the last lines name the rest)" if comparison.not_compared else ""
    return f"no change of the arm beyond chance{rest}"


def _caution(comparison: Comparison, lacking: bool) -> list[str]:
    """Return the line for differences that models which lack something may cause; none if there are no differences or the models lack nothing."""
    if not (lacking and comparison.changed):
        return []
    return [
        "  this does not prove a change of the arm: the parameters of a model that lacks something depend on the poses, which may differ. "
        f"{with_what_it_lacks(comparison)}, or measure the same poses in both campaigns"
    ]


def _changes(comparison: Comparison) -> list[str]:
    """Return the lines on each change, and one if they leave a difference beyond chance."""
    lines: list[str] = []
    for change, moved in zip(comparison.changes, comparison.moved, strict=True):
        lines += _change_lines(comparison, change, moved)
    if comparison.changes and comparison.rest_p_value < comparison.alpha:
        lines.append(f"  and more, which no single parameter explains ({_chance(comparison.rest_p_value)})")
    return lines


def _positions_line(comparison: Comparison) -> str:
    """Return the line on how far predicted positions differ, and how far chance alone would move them."""
    from scalar.comparison.beyond_chance import most_by_chance
    from scalar.estimation.random_poses import RECORDS_IN_WORDS

    apart = comparison.positions_apart
    at = f", at {RECORDS_IN_WORDS}" if any(e.needs_records for e in comparison.arm.model.effects) else ""
    return (
        f"predicted positions differ by {apart.rms / MM:.3f} mm RMS, at most {apart.largest / MM:.3f} mm, after the best "
        f"fit of base and sensor{at}; chance alone would make {comparison.by_chance / MM:.3f} mm RMS, and hardly ever more than "
        f"{most_by_chance(comparison.by_chance, comparison.alpha) / MM:.3f} mm"
    )


def _sensor_line(comparison: Comparison) -> str:
    """Return the line on the sensor's place on the flange, which is of the campaigns and not of the arm."""
    campaign = comparison.campaign
    shift, turn = campaign["sensor_shift_mm"], campaign.get("sensor_turn_deg")
    std, p_value, kinds = (
        campaign.get(key) for key in ("sensor_shift_std_mm", "sensor_shift_p_value", "sensor_kinds")
    )
    error = "" if std is None else f" +- {std:.3f}"
    turned = "" if turn is None else f" and {turn:.3f} deg"
    says = f"the sensor's place on the flange differs by {shift:.3f}{error} mm{turned}: "
    if kinds:
        return f"{says}A has a {kinds[0]} and B a {kinds[1]}"
    if p_value is not None and p_value >= comparison.alpha:
        return f"{says}not beyond chance"
    if std is None:
        says += "A and B fix different parameters of the arm, to which a part of it may belong; "
    return f"{says}of the campaigns, not of the arm{_BENT if shift >= _SHOWS_A_SHIFT else ''}"


def _by_positions(effect: DisjointTerms) -> list[str]:
    """Return lines on the difference of an effect for which A and B contain different coefficients."""
    from scalar.comparison.beyond_chance import most_by_chance

    verdict = "beyond chance" if effect.beyond_chance else "no more than chance explains"
    most = most_by_chance(effect.by_chance, effect.alpha)
    lines = [
        f"{effect.name}: A and B describe it by different coefficients, so the comparison is of the positions that it causes: they differ by "
        f"{effect.apart.rms / MM:.3f} mm RMS, at most {effect.apart.largest / MM:.3f} mm, beyond what base, sensor and geometry could explain; "
        f"chance alone would make {effect.by_chance / MM:.3f} mm, and more than {most / MM:.3f} mm hardly ever: {verdict}"
    ]
    if effect.beyond_chance:
        lines.append(
            "  either the arm changed, or the poses of one campaign did not show what those of the other did; "
            "with the same coefficients in both, the comparison would distinguish the two"
        )
    return lines


def _change_lines(comparison: Comparison, change: Change, moved: Moved) -> list[str]:
    """Return a line with a change, its sizes and how far it moves positions, and one with the candidates that it cannot be distinguished from."""
    columns = change.candidate.columns
    if len(columns) > _COEFFICIENTS_SHOWN:
        sizes = f"{len(columns)} coefficients, which stand in the JSON (-o FILE.json)"
    else:
        sizes = ", ".join(
            _sized(comparison.arm.names[i], comparison.arm.units[i], value, std, size_grows(comparison, i))
            for i, value, std in zip(columns, change.value, change.std, strict=True)
        )
    lines = [
        f"  {_title(comparison, change.candidate.name)}: {sizes}; moves predicted positions by {moved.rms / MM:.3f} mm RMS, "
        f"at most {moved.largest / MM:.3f} mm ({_chance(change.p_value)})"
    ]
    effect = effects_by_candidate(comparison).get(change.candidate.name)
    # Measured torques contain the payload.
    if effect is not None and effect.load and not effect.needs_records:
        lines.append("    another payload, if it was not recorded, looks the same")
    if change.rivals:
        names = [_title(comparison, rival.name) for rival in change.rivals[:_RIVALS_SHOWN]]
        more = len(change.rivals) - len(names)
        shown = ", ".join(names) + (f" and {more} more" if more > 0 else "")
        lines.append(f"    not distinguished from: {shown}")
    return lines


def _title(comparison: Comparison, name: str) -> str:
    """Return the title of a candidate: joint and kind for a geometric parameter, the title in reports for an effect."""
    from scalar.comparison.stretch import SCALE

    kind, _, _ = name.rpartition("_")
    effects = effects_by_candidate(comparison)
    if name == SCALE:
        return name
    named = named_parameter(comparison, name)
    if kind in _KINDS and not named[-1].isdigit():  # of the base
        return f"{_KINDS[kind]} {named}"
    if kind in _KINDS:
        return f"joint {named[len(kind) + 1 :]}, {_KINDS[kind]} {named}"
    return effects[name].title if name in effects else named


def _chance(p: float) -> str:
    """Return a p-value in plain characters, or a bound where it is too small to be computed accurately."""
    from scalar.report.words import LEAST_P_VALUE

    return f"p < {LEAST_P_VALUE:.0e}" if p < LEAST_P_VALUE else f"p = {p:.1g}"


def _sized(name: str, unit: str, value: float, std: float, grows: float | None) -> str:
    """Return the change of a parameter with its standard error, in mm or deg; for an effect with the name of the coefficient.

    Args:
        name, unit: Of the parameter.
        value, std: Its change and the standard error.
        grows: For a coefficient that is shown by its size, the change [1 or -1] with which the size grows; else None.
    """
    from scalar.effects.wording import with_error

    size, shown = {"m": (MM, "mm"), "rad": (DEG, "deg")}.get(unit, (1.0, unit))
    which = f"{name.rpartition('.')[2]} " if "." in name else ""
    if grows is not None:
        which, value = f"size of {which}", grows * value
    change, error = with_error(value / size, std / size)
    signed = change.replace("−", "-", 1) if change.startswith("−") else f"+{change}"
    return f"{which}{signed} +- {error} {shown}"
